"""A real HTTP server that speaks the chat-completions protocol, and misbehaves on demand.

Run it by itself to drive with: `python tests/reason/chat_server.py --port 8100 --latency 1`, then
`--reasoner openai:reader@http://127.0.0.1:8100/v1`.
"""

from __future__ import annotations

import argparse
import json
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import mind

Request = dict[str, Any]


@dataclass
class Fault:
    """What to do instead of answering well. Fields that are not set do nothing."""

    wait_s: float = 0.0
    status: int = 200
    headers: dict[str, str] = field(default_factory=dict)
    body: bytes | None = None
    """Sent as it stands."""
    cut_after: int | None = None
    """The connection is cut after so many bytes of the body."""
    message: dict[str, Any] | None = None
    """The assistant's message in place of the mind's."""
    error: dict[str, Any] | None = None
    """The body of an error answer."""


class ChatServer:
    """Listens on a port of the loopback interface; `faults` are used up one by one, then it answers well."""

    def __init__(self, port: int = 0, latency_s: float = 0.0) -> None:
        self._http = ThreadingHTTPServer(("127.0.0.1", port), _Handler)
        self._http.daemon_threads = True
        self._http.chat = self  # type: ignore[attr-defined]
        self.latency_s = latency_s
        self.reset()

    def reset(self) -> None:
        self.faults: deque[Fault] = deque()
        self.requests: list[Request] = []
        self.headers: list[dict[str, str]] = []
        self.key: str | None = None
        self.lacks: set[str] = set()
        """What it refuses: `strict`, `tools`, `schema`."""
        self.think: Callable[[Request], dict[str, Any]] = _think

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self._http.server_port}/v1"

    def __enter__(self) -> ChatServer:
        threading.Thread(target=self._http.serve_forever, args=(0.02,), daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._http.shutdown()
        self._http.server_close()


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *_: object) -> None:
        """Quiet."""

    def do_POST(self) -> None:
        chat: ChatServer = self.server.chat  # type: ignore[attr-defined]
        request = json.loads(self.rfile.read(int(self.headers["content-length"])))
        chat.requests.append(request)
        chat.headers.append({k.lower(): v for k, v in self.headers.items()})
        fault = chat.faults.popleft() if chat.faults else Fault()
        time.sleep(chat.latency_s + fault.wait_s)
        status, body = self._answer(chat, request, fault)
        try:
            self._send(status, body, fault)
        except OSError:
            self.close_connection = True

    def _answer(self, chat: ChatServer, request: Request, fault: Fault) -> tuple[int, bytes]:
        if not self.path.endswith("/chat/completions"):
            return 404, _error("no such page")
        if chat.key is not None and self.headers["authorization"] != f"Bearer {chat.key}":
            return 401, _error("Incorrect API key provided", code="invalid_api_key")
        if fault.body is not None:
            return fault.status, fault.body
        if fault.status >= 400:
            return fault.status, json.dumps({"error": fault.error or {"message": "fault"}}).encode()
        if request["model"] == "absent":
            return 404, _error("The model `absent` does not exist", code="model_not_found")
        lacking = _lacking(request, chat.lacks)
        if lacking:
            return 400, _error(lacking)
        return 200, json.dumps(_completion(request, fault.message or chat.think(request))).encode()

    def _send(self, status: int, body: bytes, fault: Fault) -> None:
        self.send_response(status)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        for name, value in fault.headers.items():
            self.send_header(name, value)
        self.end_headers()
        if fault.cut_after is not None:
            self.wfile.write(body[: fault.cut_after])
            self.wfile.flush()
            self.close_connection = True
            self.connection.close()
            return
        self.wfile.write(body)


def _lacking(request: Request, lacks: set[str]) -> str | None:
    tools = request.get("tools", [])
    if "tools" in lacks and tools:
        return "tools are not supported by this model"
    if "strict" in lacks and any(t["function"].get("strict") for t in tools):
        return "unknown field: strict"
    if "schema" in lacks and "response_format" in request:
        return "response_format json_schema is not supported"
    return None


def _error(text: str, **more: Any) -> bytes:
    return json.dumps({"error": {"message": text, **more}}).encode()


def scene_of(request: Request) -> str:
    """The first user turn's text."""
    content = next(m["content"] for m in request["messages"] if m["role"] == "user")
    return content if isinstance(content, str) else next(part["text"] for part in content if part["type"] == "text")


def schema_of(request: Request) -> dict[str, Any]:
    """The schema that is asked for, wherever the request holds it."""
    if request.get("tools"):
        return request["tools"][0]["function"]["parameters"]
    if "response_format" in request:
        return request["response_format"]["json_schema"]["schema"]
    system = request["messages"][0]["content"]
    return json.loads(system[system.index('{"type":"object"') :])


def behaviors_of(schema: dict[str, Any]) -> list[str]:
    plan = schema["properties"]["decision"]["properties"]["behaviors"]["anyOf"][0]
    return [one["properties"]["name"]["enum"][0] for one in plan["items"]["anyOf"]]


def call(name: str, arguments: str) -> dict[str, Any]:
    """An assistant's message that calls a function."""
    one = {"id": "call_1", "type": "function", "function": {"name": name, "arguments": arguments}}
    return {"role": "assistant", "content": None, "tool_calls": [one]}


def _think(request: Request) -> dict[str, Any]:
    text = json.dumps(mind.answer(scene_of(request), behaviors_of(schema_of(request))))
    if request.get("tools"):
        return call("decide", text)
    prose = "response_format" not in request
    return {"role": "assistant", "content": f"Let me think. Here it is:\n```json\n{text}\n```" if prose else text}


def _tokens(message: dict[str, Any]) -> int:
    """A token for four characters; for a picture what GPT-4o takes for one of two tiles."""
    content = message["content"]
    parts = [{"type": "text", "text": content}] if isinstance(content, str) else content or []
    return sum(len(part["text"]) // 4 if part["type"] == "text" else 85 + 2 * 170 for part in parts)


def _completion(request: Request, message: dict[str, Any]) -> dict[str, Any]:
    read = sum(map(_tokens, request["messages"]))
    return {
        "id": "chatcmpl-1",
        "object": "chat.completion",
        "created": 0,
        "model": request["model"],
        "choices": [{"index": 0, "message": message, "finish_reason": "stop"}],
        "usage": {
            "prompt_tokens": read,
            "completion_tokens": 200,
            "total_tokens": read + 200,
            "prompt_tokens_details": {"cached_tokens": 0},
        },
    }


def _main() -> None:
    parser = argparse.ArgumentParser(description="A chat-completions server that reads the prompt and nothing else.")
    parser.add_argument("--port", type=int, default=8100)
    parser.add_argument("--latency", type=float, default=0.0, help="seconds for each answer")
    options = parser.parse_args()
    with ChatServer(options.port, options.latency) as server:
        print(f"listening on {server.url}", flush=True)
        threading.Event().wait()


if __name__ == "__main__":
    _main()
