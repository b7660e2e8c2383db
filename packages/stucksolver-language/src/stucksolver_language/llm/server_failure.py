"""Reads failures that servers report, in error responses and inside responses of status 200, whatever their form."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from email.utils import parsedate_to_datetime
from time import time
from typing import Any

DEEPEST = 8
"""Deepest nesting in which a server's words are searched. Ours."""
MOST_WORDS = 300
"""Longest quotation of a server (characters). Ours."""
STATUS_OF = {
    "invalid_argument": 400,
    "invalid_request_error": 400,
    "failed_precondition": 400,
    "unauthenticated": 401,
    "authentication_error": 401,
    "invalid_api_key": 401,
    "insufficient_quota": 402,
    "billing_error": 402,
    "permission_denied": 403,
    "permission_error": 403,
    "not_found": 404,
    "not_found_error": 404,
    "model_not_found": 404,
    "resource_exhausted": 429,
    "rate_limit_error": 429,
    "rate_limit_exceeded": 429,
    "too_many_requests": 429,
    "internal": 500,
    "api_error": 500,
    "server_error": 500,
    "unavailable": 503,
    "deadline_exceeded": 504,
    "overloaded_error": 529,
}
"""HTTP status that belongs to a provider's name of an error."""
_WORDS = ("raw", "message", "detail", "msg", "status_msg", "error_message", "error_description", "description", "title")
_PLACES = ("error", "errors", "detail", "metadata", "base_resp", "message", "response", "promptFeedback")
_CODES = ("code", "status", "type", "status_code", "http_code")
_PASSES = re.compile(r"overload|try again|temporar|timed?[ -]?out|unavailable|\bbusy\b|at capacity", re.IGNORECASE)
_WAIT = re.compile(r"(?:try again|retry)\s{1,3}(?:in|after)\s{1,3}(\d{1,9}(?:\.\d{1,9})?)\s?(ms|s)\b", re.IGNORECASE)


@dataclass(frozen=True)
class ServerFailure:
    """What a server says about a failure.

    `status` is None if the server states none. `withheld` is True if the model declined or a filter removed the answer.
    """

    message: str
    status: int | None = None
    code: str | None = None
    parameter: str | None = None
    after_s: float | None = None
    withheld: bool = False


def failure_of(body: Any, status: int | None, fallback: str, headers: Mapping[str, str] | None = None) -> ServerFailure:
    """Return the failure that a body reports.

    Args:
        body: The parsed body, of any type.
        status: The HTTP status; None if it was 200, so that the body tells.
        fallback: Text to quote if the body holds no words.
        headers: Headers of the response.
    """
    message = one_line(words_of(body) or fallback)
    code, parameter = _first(body, ("code",), str), _first(body, ("param",), str)
    after_s = _stated_wait(headers or {}, body, message)
    return ServerFailure(message, status or _status(body, message), code, parameter, after_s)


def reported_error(body: Any) -> Any:
    """Return the error inside a body of status 200, or None."""
    for place in (body, _first_choice(body)):
        if isinstance(place, list) and place and isinstance(place[0], dict) and place[0].get("error"):
            return place
        if isinstance(place, dict):
            if place.get("error") or place.get("errors"):
                return place
            if place.get("object") == "error" or place.get("type") == "error":
                return place
    return None


def words_of(body: Any, depth: int = 0) -> str:
    """Return the most specific words in a body: the provider's own before those of a proxy. Empty if there are none."""
    if isinstance(body, str):
        return body.strip() if depth else ""
    if depth > DEEPEST:
        return ""
    if isinstance(body, list):
        return next((words for item in body[:8] if (words := words_of(item, depth + 1))), "")
    if not isinstance(body, dict):
        return ""
    inner = [words_of(body[key], depth + 1) for key in _PLACES if isinstance(body.get(key), dict | list)]
    own = [body[key] for key in _WORDS if isinstance(body.get(key), str) and body[key].strip()]
    said = [body["error"]] if isinstance(body.get("error"), str) else []
    found = [words for words in (*said, *own, *inner) if words]
    outer = found[0] if found else ""
    # A proxy such as OpenRouter says that its provider failed, and quotes the provider in its metadata.
    quoted = body.get("metadata")
    provider = words_of(quoted, depth + 1) if isinstance(quoted, dict) else ""
    return f"{outer}: {provider}" if provider and provider != outer else outer


def one_line(text: str) -> str:
    """Return a text as one line of bounded length."""
    return " ".join(text[: 8 * MOST_WORDS].split())[:MOST_WORDS]


def _status(body: Any, message: str) -> int | None:
    for value in _values(body, _CODES):
        if isinstance(value, str) and value.strip().isdecimal():
            value = int(value[:6])
        if isinstance(value, int) and not isinstance(value, bool) and 400 <= value < 600:
            return value
        if isinstance(value, str) and value.strip().lower() in STATUS_OF:
            return STATUS_OF[value.strip().lower()]
    return 503 if _PASSES.search(message) else None


def _first(body: Any, keys: tuple[str, ...], kind: type[str]) -> str | None:
    return next((value for value in _values(body, keys) if isinstance(value, kind) and value), None)


def _values(body: Any, keys: tuple[str, ...], depth: int = 0) -> list[Any]:
    """Return the values of some fields, the outer ones first."""
    if depth > DEEPEST:
        return []
    if isinstance(body, list):
        return [value for item in body[:8] for value in _values(item, keys, depth + 1)]
    if not isinstance(body, dict):
        return []
    own = [body[key] for key in keys if key in body]
    places = [body[place] for place in (*_PLACES, "details") if place in body]
    return own + [value for place in places for value in _values(place, keys, depth + 1)]


def _first_choice(body: Any) -> Any:
    choices = body.get("choices") if isinstance(body, dict) else None
    return choices[0] if isinstance(choices, list) and choices else None


def _stated_wait(headers: Mapping[str, str], body: Any, message: str) -> float | None:
    """Return the time to wait that a server states (s): in a header, in its error, or in words."""
    milliseconds = _number(headers.get("retry-after-ms"))
    if milliseconds is not None:
        return milliseconds / 1e3
    stated = headers.get("retry-after")
    if stated is not None:
        return _number(stated) if _number(stated) is not None else _until(stated)
    delay = next((v for v in _values(body, ("retryDelay", "retry_after")) if isinstance(v, str | int | float)), None)
    if delay is not None:
        return _number(str(delay).removesuffix("s"))
    found = _WAIT.search(message)
    return None if found is None else float(found[1]) / (1e3 if found[2].lower() == "ms" else 1.0)


def _number(text: str | None) -> float | None:
    try:
        value = float(text) if text is not None else None
    except ValueError:
        # It may be a date.
        return None
    return None if value is None or value != value or value == float("inf") else max(value, 0.0)


def _until(date: str) -> float | None:
    try:
        return max(parsedate_to_datetime(date).timestamp() - time(), 0.0)
    except (ValueError, TypeError, OverflowError):
        # Without a valid date, the caller uses its own pause.
        return None
