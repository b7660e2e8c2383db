"""Any server that speaks OpenAI's chat completions: OpenAI itself, vLLM, Ollama, llama.cpp and others."""

from __future__ import annotations

import base64
import json
import os
from collections.abc import Sequence
from enum import Enum
from typing import Any

from stucksolver.reason.llm.chat import GiveUp, Message, Reply, Tool, ToolCall, TryAgain, Usage
from stucksolver.reason.llm.loop import Cancelled, Loop, OutOfTime
from stucksolver.reason.llm.prompt import prose_appendix

KEY_VARIABLE = "OPENAI_API_KEY"
URL_VARIABLE = "OPENAI_BASE_URL"
LARGEST_IMAGE_BYTES = 5_000_000
MOST_TOKENS = 1500
"""Of an answer."""


class Dialect(Enum):
    """How the one function call is asked for; the first that the server takes is kept."""

    STRICT_TOOL = "strict tool"
    TOOL = "tool"
    JSON_SCHEMA = "json schema"
    PROSE = "prose"


class OpenAiChat:
    """One model behind one address. The key comes from the environment, never from a file or an argument."""

    def __init__(self, model: str, base_url: str | None = None) -> None:
        self.model, self.base_url = model, base_url or os.environ.get(URL_VARIABLE)
        self.name = f"openai:{model}" + (f"@{base_url}" if base_url else "")
        self.dialect = Dialect.STRICT_TOOL
        self._loop = Loop()
        self._client: Any = None

    def chat(self, messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None, limit_s: float) -> Reply:
        """As in `ChatModel`. A server that refuses a dialect is asked again in the next one within the same limit."""
        client = self._connect()
        try:
            return self._loop.run(self._exchange(client, messages, tools, must_call), limit_s)
        except OutOfTime:
            raise TryAgain(f"{self._where} gave no answer within {limit_s:.1f} s") from None
        except Cancelled:
            raise GiveUp("the question was withdrawn") from None

    def cancel(self) -> None:
        self._loop.cancel()

    @property
    def _where(self) -> str:
        return self.base_url or "api.openai.com"

    def _connect(self) -> Any:
        """The SDK's client, made once; the SDK takes most of a second to import, so it comes in late."""
        if self._client is None:
            try:
                import openai
            except ImportError as error:
                raise GiveUp("the openai package is not installed: pip install 'stucksolver[llm]'") from error
            key = os.environ.get(KEY_VARIABLE)
            if not key and self.base_url is None:
                raise GiveUp(f"no key: set {KEY_VARIABLE}, or name a server of your own as openai:MODEL@BASE_URL")
            # A server of one's own asks for no key, but the SDK does.
            self._client = openai.AsyncOpenAI(api_key=key or "none", base_url=self.base_url, max_retries=0)
        return self._client

    async def _exchange(
        self, client: Any, messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None
    ) -> Reply:
        import openai

        try:
            answer = await client.chat.completions.create(**self._request(messages, tools, must_call))
            return _reply(answer, self.model)
        except openai.OpenAIError as error:
            status = getattr(error, "status_code", None)
            if status not in (400, 422, 500) or not self._next_dialect(error):
                raise _translated(error, self) from error
        except (ValueError, TypeError, AttributeError, LookupError) as error:
            # The SDK hands bodies that are no completion on as they are, or fails on them in its own ways.
            raise TryAgain(f"{self._where} answered what is no chat completion") from error
        return await self._exchange(client, messages, tools, must_call)

    def _next_dialect(self, error: Any) -> bool:
        """Steps down where the server says that it does not know what was asked for."""
        text = str(error).lower()
        told = any(word in text for word in ("tool", "function", "strict", "schema", "response_format", "guided"))
        dialects = list(Dialect)
        at = dialects.index(self.dialect)
        if not told or at + 1 == len(dialects):
            return False
        self.dialect = dialects[at + 1]
        return True

    def _request(self, messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None) -> dict[str, Any]:
        final = next(tool for tool in tools if must_call is None or tool.name == must_call)
        request: dict[str, Any] = {
            "model": self.model,
            "messages": [_turn(m) for m in messages],
            "temperature": 0,
            "max_completion_tokens" if self.base_url is None else "max_tokens": MOST_TOKENS,
        }
        if self.dialect in (Dialect.STRICT_TOOL, Dialect.TOOL):
            strict = self.dialect is Dialect.STRICT_TOOL
            request["tools"] = [_function(tool, strict) for tool in tools]
            named = {"type": "function", "function": {"name": final.name}}
            request["tool_choice"] = "required" if must_call is None else named
            if strict:
                request["parallel_tool_calls"] = False
        elif self.dialect is Dialect.JSON_SCHEMA:
            schema = {"name": final.name, "strict": True, "schema": final.parameters}
            request["response_format"] = {"type": "json_schema", "json_schema": schema}
        else:
            request["messages"][0]["content"] += prose_appendix(final)
        return request


def _function(tool: Tool, strict: bool) -> dict[str, Any]:
    function: dict[str, Any] = {
        "name": tool.name,
        "description": tool.description,
        "parameters": tool.parameters,
    }
    return {"type": "function", "function": {**function, "strict": True} if strict else function}


def _turn(message: Message) -> dict[str, Any]:
    if message.role == "tool":
        return {"role": "tool", "tool_call_id": message.call_id, "content": message.text}
    turn: dict[str, Any] = {"role": message.role, "content": message.text}
    if message.calls:
        turn["tool_calls"] = [
            {"id": c.id, "type": "function", "function": {"name": c.name, "arguments": c.arguments}}
            for c in message.calls
        ]
    if message.image is not None:
        jpeg = message.image.jpeg
        if len(jpeg) > LARGEST_IMAGE_BYTES:
            raise GiveUp(f"the image has {len(jpeg)} bytes, more than {LARGEST_IMAGE_BYTES}; set a smaller camera")
        url = "data:image/jpeg;base64," + base64.b64encode(jpeg).decode()
        turn["content"] = [
            {"type": "text", "text": message.text},
            {"type": "image_url", "image_url": {"url": url, "detail": "auto"}},
        ]
    return turn


def _reply(answer: Any, asked: str) -> Reply:
    """Reads an SDK object; whatever a server left out is taken as absent."""
    choices = getattr(answer, "choices", None)
    if not choices:
        raise TryAgain("the server answered without a choice")
    message = choices[0].message
    refusal = getattr(message, "refusal", None)
    if refusal:
        raise GiveUp(f"the model refuses: {str(refusal)[:200]}")
    calls = tuple(
        ToolCall(str(c.id), str(c.function.name), _text(c.function.arguments))
        for c in (message.tool_calls or ())
        if getattr(c, "function", None) is not None
    )
    return Reply(_text(message.content), calls, _usage(getattr(answer, "usage", None)), str(answer.model or asked))


def _text(value: Any) -> str:
    """Some servers hand arguments over as an object instead of a text."""
    if value is None:
        return ""
    return value if isinstance(value, str) else json.dumps(value)


def _usage(usage: Any) -> Usage | None:
    if usage is None or not isinstance(getattr(usage, "prompt_tokens", None), int):
        return None
    details = getattr(usage, "prompt_tokens_details", None)
    cached = getattr(details, "cached_tokens", None) or 0
    return Usage(usage.prompt_tokens, usage.completion_tokens or 0, cached)


def _translated(error: Any, chat: OpenAiChat) -> Exception:
    """The SDK's error in our words, with what to do."""
    import openai

    where = chat._where
    if isinstance(error, openai.APITimeoutError):
        return TryAgain(f"{where} gave no answer in time")
    if isinstance(error, openai.APIConnectionError):
        return _no_connection(error, where)
    if isinstance(error, openai.AuthenticationError | openai.PermissionDeniedError):
        return GiveUp(f"{where} refuses the key: set {KEY_VARIABLE} to one that may use {chat.model}")
    if isinstance(error, openai.NotFoundError):
        return GiveUp(f"{where} has no model {chat.model!r}, or no chat completions under that address")
    if isinstance(error, openai.RateLimitError):
        return _rate_limit(error, where)
    if isinstance(error, openai.APIStatusError) and error.status_code >= 500:
        return TryAgain(f"{where} answered {error.status_code}", _after(error))
    if isinstance(error, openai.APIStatusError):
        return GiveUp(f"{where} answered {error.status_code}: {_said(error)}")
    return TryAgain(f"{where} answered what is no chat completion: {str(error)[:200]}")


def _no_connection(error: Any, where: str) -> Exception:
    cause: BaseException | None = error
    while cause is not None:
        if "CERTIFICATE" in str(cause).upper():
            return GiveUp(f"{where} shows a certificate that is not trusted: set SSL_CERT_FILE to its issuer's")
        cause = cause.__cause__ or cause.__context__
    return TryAgain(f"{where} cannot be reached, or broke off: is it running, is the address right?")


def _rate_limit(error: Any, where: str) -> Exception:
    if getattr(error, "code", None) == "insufficient_quota":
        return GiveUp(f"{where}: the account's quota is used up")
    return TryAgain(f"{where} is asked too often", _after(error))


def _after(error: Any) -> float | None:
    try:
        return max(float(error.response.headers["retry-after"]), 0.0)
    except (KeyError, ValueError, AttributeError):
        return None


def _said(error: Any) -> str:
    body = getattr(error, "body", None)
    text = body.get("message") if isinstance(body, dict) else None
    return str(text or error)[:200]
