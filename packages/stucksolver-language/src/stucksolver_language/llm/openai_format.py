"""Converts messages to OpenAI's chat completions format, and replies back."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Sequence
from typing import Any

from stucksolver_language.llm.capabilities import Dialect, ServerCapabilities
from stucksolver_language.llm.chat import (
    ChatReply,
    Finish,
    Message,
    PermanentReasonerError,
    Tool,
    ToolCall,
    TransientKind,
    TransientReasonerError,
    Usage,
)
from stucksolver_language.llm.prompt import FORM, prose_appendix

LARGEST_IMAGE_BYTES = 5_000_000
"""Largest image in a request (bytes). Ours."""
NOT_IN_STRICT_MODE = frozenset({"maxLength"})
FINISHES = {"stop": Finish.WHOLE, "tool_calls": Finish.WHOLE, "function_call": Finish.WHOLE, "length": Finish.CUT_OFF}


def request_of(
    model: str, messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None, takes: ServerCapabilities
) -> dict[str, Any]:
    """Return the body of a request.

    Raises:
        PermanentReasonerError: An image is too large.
    """
    final = next(tool for tool in tools if must_call is None or tool.name == must_call)
    request: dict[str, Any] = {
        "model": model,
        "messages": [_turn(m, takes.pictures) for m in messages],
        takes.token_field: takes.most_tokens,
    }
    if takes.temperature:
        request["temperature"] = 0
    if takes.effort is not None:
        request["reasoning_effort"] = takes.effort
    if takes.dialect in (Dialect.STRICT_TOOL, Dialect.TOOL):
        _ask_by_tool(request, tools, None if must_call is None else final.name, takes)
    elif takes.dialect is Dialect.JSON_SCHEMA:
        schema = {"name": final.name, "strict": True, "schema": _within(final.parameters, takes)}
        request["response_format"] = {"type": "json_schema", "json_schema": schema}
        request["messages"][0]["content"] += FORM if final.name == "decide" else ""
    else:
        request["messages"][0]["content"] += prose_appendix(final)
    return request


def _ask_by_tool(request: dict[str, Any], tools: Sequence[Tool], name: str | None, takes: ServerCapabilities) -> None:
    strict = takes.dialect is Dialect.STRICT_TOOL
    request["tools"] = [_function(tool, strict, takes) for tool in tools]
    request["tool_choice"] = "required" if name is None else {"type": "function", "function": {"name": name}}
    if strict and takes.parallel:
        request["parallel_tool_calls"] = False


def _function(tool: Tool, strict: bool, takes: ServerCapabilities) -> dict[str, Any]:
    function = {"name": tool.name, "description": tool.description, "parameters": _within(tool.parameters, takes)}
    return {"type": "function", "function": {**function, "strict": True} if strict else function}


def _within(schema: Any, takes: ServerCapabilities) -> Any:
    """Return a schema without the keywords that OpenAI's strict mode rejects."""
    if not takes.strict_subset:
        return schema
    if isinstance(schema, dict):
        return {key: _within(value, takes) for key, value in schema.items() if key not in NOT_IN_STRICT_MODE}
    return [_within(value, takes) for value in schema] if isinstance(schema, list) else schema


def _turn(message: Message, pictures: bool) -> dict[str, Any]:
    if message.role == "tool":
        return {"role": "tool", "tool_call_id": message.call_id, "content": message.text}
    turn: dict[str, Any] = {"role": message.role, "content": message.text}
    if message.calls:
        turn["tool_calls"] = [
            {"id": c.id, "type": "function", "function": {"name": c.name, "arguments": c.arguments}}
            for c in message.calls
        ]
    if message.image is not None and pictures:
        jpeg = message.image.jpeg
        if len(jpeg) > LARGEST_IMAGE_BYTES:
            raise PermanentReasonerError(
                f"image too large: {len(jpeg)} bytes, at most {LARGEST_IMAGE_BYTES}; use a smaller camera image"
            )
        url = "data:image/jpeg;base64," + base64.b64encode(jpeg).decode()
        turn["content"] = [
            {"type": "text", "text": message.text},
            {"type": "image_url", "image_url": {"url": url, "detail": "auto"}},
        ]
    return turn


def reply_of(answer: Any, asked: str, saw: bool, clean: Callable[[str], str] = str) -> ChatReply:
    """Convert an SDK object to a reply.

    Fields that a server omits count as absent. `clean` makes its text safe to display.

    Raises:
        TransientReasonerError: The answer has no choice.
        PermanentReasonerError: A content filter withheld the answer, or the model declines.
    """
    choices = getattr(answer, "choices", None)
    if not choices:
        raise TransientReasonerError("the server's answer has no choice", TransientKind.BROKEN)
    message = choices[0].message
    refusal = getattr(message, "refusal", None)
    if refusal:
        raise PermanentReasonerError(f"the model declines to answer: {clean(str(refusal))[:200]}")
    finish = getattr(choices[0], "finish_reason", None)
    if finish == "content_filter":
        raise PermanentReasonerError("the provider's content filter withheld the answer")
    calls = tuple(
        ToolCall(str(c.id), str(c.function.name), _text(c.function.arguments))
        for c in (message.tool_calls or ())
        if getattr(c, "function", None) is not None
    )
    usage = _usage(getattr(answer, "usage", None))
    return ChatReply(
        _text(message.content), calls, usage, str(answer.model or asked), FINISHES.get(str(finish), Finish.UNTOLD), saw
    )


def _text(value: Any) -> str:
    """Return a text. Some servers return arguments as an object instead."""
    if value is None:
        return ""
    return value if isinstance(value, str) else json.dumps(value)


def _usage(usage: Any) -> Usage | None:
    if usage is None or not isinstance(getattr(usage, "prompt_tokens", None), int):
        return None
    details = getattr(usage, "prompt_tokens_details", None)
    cached = getattr(details, "cached_tokens", None) or 0
    return Usage(usage.prompt_tokens, usage.completion_tokens or 0, cached)
