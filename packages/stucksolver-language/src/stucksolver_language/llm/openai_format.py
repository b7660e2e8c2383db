"""Converts messages and tools to OpenAI's chat completions format."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

from stucksolver_language.llm.capabilities import ServerCapabilities
from stucksolver_language.llm.chat import Message, PermanentReasonerError, Tool, ToolCall
from stucksolver_language.llm.dialects import Dialect, ToolChoice
from stucksolver_language.llm.prompt import form_text, prose_appendix

LARGEST_IMAGE_BYTES = 5_000_000
"""Largest image in a request (bytes). Ours."""
LIMITS = frozenset(
    {"maxLength", "minLength", "maxItems", "minItems", "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"}
)
"""Keywords of a schema that some servers reject or take very long to enforce. The parser checks the limits anyway."""


def request_of(
    model: str, messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None, takes: ServerCapabilities
) -> dict[str, Any]:
    """Return the body of a request.

    Raises:
        PermanentReasonerError: An image is too large.
    """
    final = next(tool for tool in tools if must_call is None or tool.name == must_call)
    if not takes.returns_calls or takes.dialect not in (Dialect.STRICT_TOOL, Dialect.TOOL):
        # Servers reject calls in a request that declares no function.
        messages = quoted(messages)
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
        request["messages"][0]["content"] += form_text(final)
    else:
        request["messages"][0]["content"] += prose_appendix(final)
    if not takes.system:
        request["messages"] = _without_system(request["messages"])
    if takes.body:
        # The SDK adds these fields, also those that it does not know.
        request["extra_body"] = takes.body
    return request


def quoted(messages: Sequence[Message]) -> list[Message]:
    """Return a conversation with its calls and the first response to each turn's calls as text."""
    turns: list[Message] = []
    for message in messages:
        if message.calls:
            said = [message.text] if message.text else []
            turns.append(Message(message.role, "\n".join(said + [call.arguments for call in message.calls])))
        elif message.role != "tool":
            turns.append(message)
        elif turns[-1].role == "assistant":
            turns.append(Message("user", message.text))
    return turns


def _ask_by_tool(request: dict[str, Any], tools: Sequence[Tool], name: str | None, takes: ServerCapabilities) -> None:
    strict = takes.dialect is Dialect.STRICT_TOOL
    request["tools"] = [_function(tool, strict, takes) for tool in tools]
    if takes.tool_choice is not ToolChoice.NAMED:
        request["tool_choice"] = takes.tool_choice.value
    else:
        request["tool_choice"] = "required" if name is None else {"type": "function", "function": {"name": name}}
    if strict and takes.parallel:
        request["parallel_tool_calls"] = False


def _function(tool: Tool, strict: bool, takes: ServerCapabilities) -> dict[str, Any]:
    function = {"name": tool.name, "description": tool.description, "parameters": _within(tool.parameters, takes)}
    return {"type": "function", "function": {**function, "strict": True} if strict else function}


def _within(schema: Any, takes: ServerCapabilities) -> Any:
    """Return a schema without the keywords that the server rejects."""
    return _without(schema, takes.refused_keywords | (frozenset() if takes.limits else LIMITS))


def _without(schema: Any, keywords: frozenset[str]) -> Any:
    if not keywords:
        return schema
    if isinstance(schema, dict):
        return {key: _without(value, keywords) for key, value in schema.items() if key not in keywords}
    return [_without(value, keywords) for value in schema] if isinstance(schema, list) else schema


def _without_system(turns: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the turns with the system's text at the beginning of the first user's turn."""
    system, first, *others = turns
    content = first["content"]
    if isinstance(content, str):
        content = f"{system['content']}\n\n{content}"
    else:
        content = [{"type": "text", "text": system["content"]}, *content]
    return [{**first, "content": content}, *others]


def _turn(message: Message, pictures: bool) -> dict[str, Any]:
    if message.role == "tool":
        return {"role": "tool", "tool_call_id": message.call_id, "content": message.text}
    turn: dict[str, Any] = {"role": message.role, "content": message.text, **message.extra}
    if message.calls:
        turn["tool_calls"] = [_call(call) for call in message.calls]
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


def _call(call: ToolCall) -> dict[str, Any]:
    function = {"name": call.name, "arguments": call.arguments}
    return {"id": call.id, "type": "function", "function": function, **call.extra}
