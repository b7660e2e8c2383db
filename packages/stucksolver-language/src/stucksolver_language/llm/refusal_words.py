"""Words with which servers reject a part of a request."""

from __future__ import annotations

import re

LEAST_TOKENS = 700
"""An answer with less room cannot be complete (tokens): that much a normal one takes."""
PARAMETERS = (
    "temperature",
    "max_tokens",
    "max_completion_tokens",
    "reasoning_effort",
    "parallel_tool_calls",
    "tool_choice",
)
"""Fields of a request that are omitted or changed if a server names them."""
_OF_DIALECTS = ("tool", "function", "strict", "schema", "response_format", "guided", "grammar", "json")
_SCHEMA_TOO_HARD = re.compile(
    r"too many states|too complex|complexity|m(?:ax|in)(?:Length|Items|imum)|exclusiveM(?:ax|in)imum"
)
_OF_CALLS = re.compile(
    r"(?i)tool[_ ]?calls?\b|function_?call|\btool (?:message|role|result)|role.{0,60}\btool\b|reasoning_"
    r"|thought_?signature|alternat|arguments"
)
_SYSTEM = re.compile(r"(?i)system.{0,40}(?:not supported|unsupported|not allowed)|roles must alter")
_TOKEN_BOUND = re.compile(
    r"(?i)(?:at most|maximum(?: value)?(?: of| is)?|less than or equal to|up to|<=|limit(?: of| is)?|\[1,)"
    r"\s{0,3}(\d{2,7})"
)
_THIS_PICTURE = re.compile(
    r"(?i)(?:could not|unable to|failed to|cannot) (?:process|decode|load|read|download|parse)\b.{0,30}image"
    r"|(?:invalid|corrupt\w*|truncated|unsafe) image(?! type)|invalid_image|image.{0,40}(?:policy|safety|moderation)"
)


def stated_most_tokens(message: str) -> int | None:
    """Return the upper bound on the tokens of an answer that a message states, or None."""
    found = _TOKEN_BOUND.search(message)
    return int(found[1]) if found and int(found[1]) >= LEAST_TOKENS else None


def rejects_dialect(message: str) -> bool:
    """True if a message rejects functions, a response format or strict mode."""
    return any(word in message.lower() for word in _OF_DIALECTS)


def rejects_calls(message: str) -> bool:
    """True if a message rejects a call, the response to it, or the thoughts with it, when they come back."""
    return _OF_CALLS.search(message) is not None


def rejects_system(message: str) -> bool:
    """True if a message rejects the system's turn."""
    return _SYSTEM.search(message) is not None


def rejects_size(message: str) -> bool:
    """True if a message rejects a schema because of its size or its limits."""
    return _SCHEMA_TOO_HARD.search(message) is not None


def rejects_pictures(message: str) -> bool:
    """True if a message rejects images in general, not only an image that is too large."""
    text = message.lower()
    if re.search(r"too (?:large|big)|exceed|dimension", text) or rejects_one_picture(message):
        return False
    asks_for_text = "content" in text and "string" in text
    return asks_for_text or re.search(r"image|vision|multi-?modal|modalit|mmproj", text) is not None


def rejects_one_picture(message: str) -> bool:
    """True if a message rejects the image that was sent, not images in general."""
    return _THIS_PICTURE.search(message) is not None
