"""A real HTTP server that speaks the chat-completions protocol, and misbehaves on demand.

Run it by itself to drive with: `python packages/stucksolver-language/tests/llm/chat_server.py --port 8100 --latency
1`, then `--reasoner openai:reader@http://127.0.0.1:8100/v1`.
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
    finish: str = "stop"
    """Why the answer ends: `length` for one that was cut off."""


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
        self.paths: list[str] = []
        self.key: str | None = None
        self.lacks: set[str] = set()
        """What it refuses: `strict`, `tools`, `schema`, `pictures`, or a field of the request."""
        self.ignores: set[str] = set()
        """What it takes and answers in prose all the same: `tools`, `schema`."""
        self.models: list[dict[str, Any]] | None = None
        """Its list of models; None: it has none."""
        self.counts = True
        """Does it count tokens?"""
        self.counts_pictures = True
        """Does it count tokens of pictures? One that drops them silently does not."""
        self.refuses: tuple[Callable[[Request], bool], str] | None = None
        """Requests that it refuses with 400, and the words."""
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

    def do_GET(self) -> None:
        chat: ChatServer = self.server.chat  # type: ignore[attr-defined]
        if not self.path.endswith("/models") or chat.models is None:
            return self._send(404, _error("no such page"), Fault())
        self._send(200, json.dumps({"object": "list", "data": chat.models}).encode(), Fault())

    def do_POST(self) -> None:
        chat: ChatServer = self.server.chat  # type: ignore[attr-defined]
        request = json.loads(self.rfile.read(int(self.headers["content-length"])))
        chat.requests.append(request)
        chat.headers.append({k.lower(): v for k, v in self.headers.items()})
        chat.paths.append(self.path)
        fault = chat.faults.popleft() if chat.faults else Fault()
        time.sleep(chat.latency_s + fault.wait_s)
        status, body = self._answer(chat, request, fault)
        try:
            self._send(status, body, fault)
        except OSError:
            self.close_connection = True

    def _answer(self, chat: ChatServer, request: Request, fault: Fault) -> tuple[int, bytes]:
        if not self.path.partition("?")[0].endswith("/chat/completions"):
            return 404, _error("no such page")
        if chat.key is not None and chat.key not in (self.headers["api-key"], _bearer(self.headers["authorization"])):
            return 401, _error("Incorrect API key provided", code="invalid_api_key")
        if fault.body is not None:
            return fault.status, fault.body
        if fault.status >= 400:
            return fault.status, json.dumps({"error": fault.error or {"message": "fault"}}).encode()
        if request["model"] == "absent":
            return 404, _error("The model `absent` does not exist", code="model_not_found")
        if chat.refuses is not None and chat.refuses[0](request):
            return 400, _error(chat.refuses[1])
        lacking = _lacking(request, chat.lacks)
        if lacking:
            status, text, more = lacking
            return status, _error(text, **more)
        message = fault.message or (_prose() if _ignored(request, chat.ignores) else chat.think(request))
        return 200, json.dumps(_completion(request, message, fault.finish, chat)).encode()

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


def _bearer(header: str | None) -> str | None:
    return None if header is None else header.removeprefix("Bearer ")


def _lacking(request: Request, lacks: set[str]) -> tuple[int, str, dict[str, Any]] | None:
    """As real servers word it: llama.cpp on pictures, OpenAI on parameters of reasoning models."""
    tools = request.get("tools", [])
    if "tools" in lacks and tools:
        return 400, "tools are not supported by this model", {}
    if "strict" in lacks and any(t["function"].get("strict") for t in tools):
        return 400, "unknown field: strict", {}
    if "schema" in lacks and "response_format" in request:
        return 400, "response_format json_schema is not supported", {}
    if "pictures" in lacks and any(isinstance(m["content"], list) for m in request["messages"]):
        hint = "image input is not supported - hint: if this is unexpected, you may need to provide the mmproj"
        return 500, hint, {"code": 500, "type": "server_error"}
    field = next((name for name in request if name in lacks), None)
    if field == "max_tokens":
        text = (
            "Unsupported parameter: 'max_tokens' is not supported with this model. Use 'max_completion_tokens' instead."
        )
        return 400, text, {"param": field, "code": "unsupported_parameter"}
    if field is not None:
        text = f"Unsupported value: '{field}' does not support {request[field]} with this model."
        return 400, text, {"param": field, "code": "unsupported_value"}
    return None


def _ignored(request: Request, ignores: set[str]) -> bool:
    return ("tools" in ignores and "tools" in request) or ("schema" in ignores and "response_format" in request)


def said(text: str) -> dict[str, Any]:
    """An assistant's message."""
    return {"role": "assistant", "content": text}


def _prose() -> dict[str, Any]:
    """What llama.cpp and Ollama answer where a named function is a suggestion to them."""
    return {
        "role": "assistant",
        "content": "1. The vehicle is not allowed to move forward, but it can move in the lane.",
    }


def _error(text: str, **more: Any) -> bytes:
    return json.dumps({"error": {"message": text, **more}}).encode()


def scene_of(request: Request) -> str:
    """The first user turn's text, without that of a system turn before it."""
    content = next(m["content"] for m in request["messages"] if m["role"] == "user")
    return content if isinstance(content, str) else [part["text"] for part in content if part["type"] == "text"][-1]


def schema_of(request: Request) -> dict[str, Any]:
    """The schema that is asked for, wherever the request holds it."""
    if request.get("tools"):
        return request["tools"][0]["function"]["parameters"]
    if "response_format" in request:
        return request["response_format"]["json_schema"]["schema"]
    system = request["messages"][0]["content"]
    return json.loads(system[system.index('{"type":"object"') :])


def behaviors_of(schema: dict[str, Any]) -> list[str]:
    """Those that can be expressed in a plan."""
    return [item["$ref"].rpartition("/")[2] for item in schema["$defs"]["behavior"]["anyOf"]]


def available_in(text: str) -> list[str]:
    """The behaviors that a scene's text names as available."""
    line = next(line for line in text.splitlines() if line.startswith("behaviors available now: "))
    return line.partition(": ")[2].split(", ")


def picture_of(request: Request) -> bool:
    """Does a request hold a picture?"""
    return any(isinstance(message["content"], list) for message in request["messages"])


def call(name: str, arguments: str) -> dict[str, Any]:
    """An assistant's message that calls a function."""
    one = {"id": "call_1", "type": "function", "function": {"name": name, "arguments": arguments}}
    return {"role": "assistant", "content": None, "tool_calls": [one]}


BEGUN = '{"observation": {"controls": [], "participants": [], "summary": "'
"""What a server that enforces the schema answers to a query without a scene, up to the limit of tokens."""


def _think(request: Request) -> dict[str, Any]:
    if "behaviors available now" not in scene_of(request):
        prose = "response_format" not in request
        return call("decide", BEGUN) if request.get("tools") else said("READY" if prose else BEGUN)
    form = mind.short_answer if "choice" in schema_of(request)["properties"] else mind.answer
    text = json.dumps(form(scene_of(request), available_in(scene_of(request))))
    if request.get("tools"):
        return call("decide", text)
    prose = "response_format" not in request
    return {"role": "assistant", "content": f"Let me think. Here it is:\n```json\n{text}\n```" if prose else text}


def _tokens(message: dict[str, Any], picture: int) -> int:
    """A token for four characters, and those of a picture."""
    content = message["content"]
    parts = [{"type": "text", "text": content}] if isinstance(content, str) else content or []
    return sum(len(part["text"]) // 4 if part["type"] == "text" else picture for part in parts)


PICTURE_TOKENS = 85 + 2 * 170
"""What GPT-4o takes for one of two tiles (tokens)."""


def _completion(request: Request, message: dict[str, Any], finish: str, chat: ChatServer) -> dict[str, Any]:
    read = sum(_tokens(turn, PICTURE_TOKENS if chat.counts_pictures else 0) for turn in request["messages"])
    return {
        "id": "chatcmpl-1",
        "object": "chat.completion",
        "created": 0,
        "model": request["model"],
        "choices": [{"index": 0, "message": message, "finish_reason": finish}],
        "usage": {
            "prompt_tokens": read,
            "completion_tokens": 200,
            "total_tokens": read + 200,
            "prompt_tokens_details": {"cached_tokens": 0},
        }
        if chat.counts
        else None,
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
