"""Normalizes the body of a chat response: text, thoughts, calls and the reason why it ended, whatever their form.

Chat completions are read, the content of which may be a text, an object, or a list of parts of any kind. Streams that
nobody requested are assembled first. The same search finds the message in the native responses of Ollama, Anthropic,
Gemini and OpenAI's newer API, which some proxies pass on.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from stucksolver_language.llm.chat import ChatReply, Finish, ToolCall
from stucksolver_language.llm.server_failure import ServerFailure, failure_of, one_line, reported_error, words_of
from stucksolver_language.llm.token_usage import usage_in
from stucksolver_language.llm.written_calls import plain_name

MOST_BODY = 4_000_000
"""Longest body that is read (characters). Ours."""
MOST_RAW = 200_000
"""Longest body that is kept for the record (characters). Ours."""
MOST_CHUNKS = 20_000
DEEPEST = 12
"""Deepest nesting of parts in parts. Ours."""
CUT_OFF = frozenset({"length", "max_tokens", "max_output_tokens", "model_length", "model_context_window_exceeded"})
WHOLE = frozenset({"stop", "tool_calls", "function_call", "tool_use", "end_turn", "stop_sequence", "completed", "eos"})
WITHHELD = frozenset(
    {"content_filter", "safety", "refusal", "recitation", "blocklist", "prohibited_content", "spii", "sensitive"}
)
"""Reasons why an answer ended, of all providers, in lower case."""
KEPT_OF_CALLS = ("extra_content", "provider_specific_fields", "thought_signature")
"""Fields of a call that must come back with it: Gemini's own endpoint, LiteLLM, and other proxies."""
KEPT_OF_MESSAGES = ("reasoning_content", "reasoning_details", "thinking_blocks")
"""Fields of a message that must come back while one of its calls is open: DeepSeek, OpenRouter, LiteLLM."""
_THOUGHTS = frozenset({"reasoning", "reasoning_content", "reasoning_text", "reasoning_details", "thinking", "thoughts"})
_CONTENT = ("content", "parts", "output", "output_text", "response", "text")
_ARGUMENTS = ("arguments", "input", "args", "parameters")
_FINISHES = ("finish_reason", "finishReason", "stop_reason", "done_reason", "native_finish_reason")


@dataclass
class _Found:
    """What the parts of a message hold."""

    texts: list[str] = field(default_factory=list)
    thoughts: list[str] = field(default_factory=list)
    calls: list[ToolCall] = field(default_factory=list)
    refusals: list[str] = field(default_factory=list)


def read_body(text: str) -> Any:
    """Return a body as parsed JSON, a stream as one response; None if it is neither."""
    if len(text) > MOST_BODY:
        return None
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        # A stream is one object a line.
        chunks = list(_chunks(text))
        return _assembled(chunks) if chunks else None


def reply_of(body: Any, raw: str, asked: str, saw: bool) -> ChatReply:
    """Return the reply in a body. It is empty if the body holds no message.

    Args:
        body: The parsed body.
        raw: The body for the record, without keys.
        asked: Name of the model in the request.
        saw: True if the request's images were sent.
    """
    found = _Found()
    message = _message(body)
    _collect(message, found, 0)
    finish = _finish(body)
    model = body.get("model") if isinstance(body, dict) else None
    return ChatReply(
        "".join(found.texts),
        tuple(found.calls),
        usage_in(body),
        model if isinstance(model, str) and model else asked,
        Finish.CUT_OFF if finish in CUT_OFF else Finish.WHOLE if finish in WHOLE else Finish.UNTOLD,
        saw,
        "\n".join(dict.fromkeys(found.thoughts)),
        raw,
        {key: message[key] for key in KEPT_OF_MESSAGES if message.get(key)} if found.calls else {},
    )


def failure_in(body: Any, raw: str) -> ServerFailure | None:
    """Return the failure that a response of status 200 reports, or None. `raw` is quoted where there are no words."""
    error = reported_error(body)
    if error is not None:
        return failure_of(error, None, one_line(raw))
    found = _Found()
    message, finish = _message(body), _finish(body)
    _collect(message, found, 0)
    if found.refusals:
        return ServerFailure(f"the model declines to answer: {one_line(' '.join(found.refusals))}", withheld=True)
    if finish in WITHHELD:
        said = one_line(" ".join(found.texts))
        filtered = "the provider's content filter withheld the answer"
        return ServerFailure(f"{filtered}: {said}" if said else f"{filtered} ({finish})", withheld=True)
    if finish not in (*CUT_OFF, *WHOLE, "") and not (found.texts or found.calls or found.thoughts):
        said = words_of(body)
        return (
            failure_of(body, None, f"the answer is empty ({finish})")
            if said
            else ServerFailure(f"the answer is empty ({finish})")
        )
    if message is None or finish == "error":
        return failure_of(body, None, f"the response begins: {one_line(raw)[:160]}")
    return None


def _chunks(text: str) -> Iterator[dict[str, Any]]:
    """Yield the objects of a stream: server-sent events, or one object a line."""
    for count, line in enumerate(text.splitlines()):
        data = line.removeprefix("data:").strip()
        if count > MOST_CHUNKS or not data.startswith("{"):
            continue
        try:
            chunk = json.loads(data)
        except (ValueError, RecursionError):
            # A line that was cut off ends the stream.
            continue
        if isinstance(chunk, dict):
            yield chunk


def _assembled(chunks: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the response of which a stream consists."""
    whole: dict[str, Any] = {}
    message: dict[str, Any] = {}
    finish = None
    for chunk in chunks:
        whole.update({key: value for key, value in chunk.items() if value is not None and key != "choices"})
        choice = _first(chunk.get("choices"))
        finish = _reason(choice) or _reason(chunk) or finish
        if choice.get("error"):
            whole["error"] = choice["error"]
        _merge(message, choice.get("delta") or choice.get("message") or chunk.get("message"), 0)
    whole.pop("message", None)
    return {**whole, "choices": [{"message": message, "finish_reason": finish}]} if message else whole


def _merge(into: dict[str, Any], part: Any, depth: int) -> None:
    """Append a part of a message: texts and lists grow, objects with the same index merge."""
    for key, value in part.items() if isinstance(part, dict) and depth < DEEPEST else ():
        before = into.get(key)
        if isinstance(before, str) and isinstance(value, str):
            into[key] = before if key in ("role", "type", "id", "name") else before + value
        elif isinstance(value, dict) and isinstance(before, dict):
            _merge(before, value, depth + 1)
        elif isinstance(value, list):
            into[key] = before if isinstance(before, list) else []
            _merge_list(into[key], value, depth)
        elif value is not None:
            into[key] = value


def _merge_list(into: list[Any], parts: list[Any], depth: int) -> None:
    for part in parts:
        index = part.get("index") if isinstance(part, dict) else None
        same = [item for item in into if index is not None and isinstance(item, dict) and item.get("index") == index]
        if same:
            _merge(same[0], part, depth + 1)
        else:
            into.append(part)


def _message(body: Any) -> Any:
    """Return the message in a response; None if there is none."""
    if not isinstance(body, dict):
        return None
    choice = _first(body.get("choices")) or _first(body.get("candidates"))
    for place in (choice, body):
        for key in ("message", "delta", "content"):
            if isinstance(place.get(key), dict):
                return place[key]
    for place in (choice, body):
        if any(place.get(key) for key in (*_CONTENT, "tool_calls", "function_call")):
            return {key: value for key, value in place.items() if key not in ("type", "error")}
    return None


def _collect(part: Any, found: _Found, depth: int) -> None:
    """Sort a part, and the parts in it, into texts, thoughts, calls and refusals."""
    if depth > DEEPEST or part is None:
        return
    if isinstance(part, str):
        found.texts += [part] if part else []
    elif isinstance(part, list):
        for item in part:
            _collect(item, found, depth + 1)
    elif isinstance(part, dict):
        kind = str(part.get("type") or "").lower()
        if part.get("thought") is True or any(word in kind for word in ("think", "reason", "thought")):
            _collect_thoughts(part, found, depth)
        elif "call" in kind or "tool_use" in kind:
            _collect_call(part, found)
        else:
            _collect_fields(part, found, depth)


def _collect_fields(part: dict[str, Any], found: _Found, depth: int) -> None:
    known = False
    for key, value in part.items():
        if key in _THOUGHTS:
            _collect_thoughts(value, found, depth)
        elif key == "refusal":
            found.refusals += [value] if isinstance(value, str) and value else []
        elif key == "tool_calls":
            for call in value if isinstance(value, list) else [value]:
                _collect_call(call, found)
        elif key in ("function_call", "functionCall", "function"):
            _collect_call(value, found)
        elif key in _CONTENT or (key in ("json", "value") and isinstance(value, dict | str)):
            _collect(value, found, depth + 1)
        else:
            continue
        known = True
    if not known and part and "type" not in part and "role" not in part:
        # The content is the answer itself, as an object.
        found.texts.append(_as_text(part))


def _collect_thoughts(part: Any, found: _Found, depth: int) -> None:
    """Collect the texts of thoughts, without signatures and encrypted data."""
    if isinstance(part, str):
        found.thoughts += [part] if part else []
    elif depth < DEEPEST and isinstance(part, list):
        for item in part:
            _collect_thoughts(item, found, depth + 1)
    elif depth < DEEPEST and isinstance(part, dict):
        for key, value in part.items():
            if key in (*_THOUGHTS, *_CONTENT, "summary"):
                _collect_thoughts(value, found, depth + 1)


def _collect_call(entry: Any, found: _Found) -> None:
    """Collect one call: with its function inside, as in chat completions, or flat, as elsewhere."""
    if not isinstance(entry, dict):
        return
    inner = next(
        (entry[key] for key in ("function", "custom", "functionCall") if isinstance(entry.get(key), dict)), entry
    )
    arguments = next((inner[key] for key in _ARGUMENTS if inner.get(key) is not None), "")
    identifier = entry.get("id") or entry.get("call_id") or f"call_{len(found.calls)}"
    extra = {key: entry[key] for key in KEPT_OF_CALLS if isinstance(entry.get(key), dict | str)}
    text = arguments if isinstance(arguments, str) else _as_text(arguments)
    found.calls.append(ToolCall(str(identifier), plain_name(str(inner.get("name") or "")), text, extra))


def _as_text(value: Any) -> str:
    try:
        return json.dumps(value)
    except (ValueError, RecursionError):
        return ""


def _finish(body: Any) -> str:
    """Return the reason why the answer ended, in lower case; empty if the server states none."""
    if not isinstance(body, dict):
        return ""
    choice = _first(body.get("choices")) or _first(body.get("candidates"))
    blocked = body.get("promptFeedback")
    details = body.get("incomplete_details")
    stated = (
        _reason(choice)
        or _reason(body)
        or (details.get("reason") if isinstance(details, dict) else None)
        or (blocked.get("blockReason") if isinstance(blocked, dict) else None)
    )
    return str(stated or "").lower()


def _reason(place: dict[str, Any]) -> str | None:
    return next((place[key] for key in _FINISHES if isinstance(place.get(key), str) and place[key]), None)


def _first(items: Any) -> dict[str, Any]:
    """Return the first item of a list if it is an object; otherwise an empty object."""
    first = items[0] if isinstance(items, list) and items else None
    return first if isinstance(first, dict) else {}
