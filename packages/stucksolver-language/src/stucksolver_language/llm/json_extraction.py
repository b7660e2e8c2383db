"""Extracts the single JSON object from a model's text and ignores the rest."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

THINKING = re.compile(r"<think(?:ing)?>.*?</think(?:ing)?>", re.DOTALL | re.IGNORECASE)
"""Thoughts of a reasoning model, which some servers leave in the text, including drafts of the answer."""
OF_AN_ANSWER = frozenset({"decision", "behaviors"})
DEEPEST_WRAPPING = 3
"""Deepest nesting of calls around the arguments that is unwrapped. Ours."""


class NoJsonError(ValueError):
    """There is no JSON object, or more than one. The message can be quoted to the model."""


def extract_json(text: str) -> str:
    """Return the object as JSON text. Prose, thoughts, code fences and a call around it are ignored.

    Raises:
        NoJsonError: There is no object, or more than one.
    """
    return _as_text(extract_call(text)[1])


def name_in(text: str) -> str | None:
    """Return the name of the function if a text writes out a call such as `{"name": "decide", "arguments": {…}}`.

    None for any other text.
    """
    try:
        return extract_call(text)[0]
    except NoJsonError:
        # The parser of the answer reports the missing object.
        return None


def extract_call(text: str) -> tuple[str | None, dict[str, Any]]:
    """Return the name of the function that a text calls, if any, and its arguments.

    Raises:
        NoJsonError: There is no object, or more than one.
    """
    found = [_unwrapped(value) for value in _objects(THINKING.sub("", text)) if isinstance(value, dict)]
    answers = [item for item in found if item[1].keys() & OF_AN_ANSWER] or found
    if not answers:
        raise NoJsonError("the answer holds no JSON object")
    if len(answers) > 1:
        raise NoJsonError("the answer holds more than one JSON object; give one")
    return answers[0]


def _unwrapped(value: dict[str, Any], depth: int = 0) -> tuple[str | None, dict[str, Any]]:
    """Return the function and the arguments of a call written as text; None and the object itself otherwise."""
    if depth == DEEPEST_WRAPPING or value.keys() & OF_AN_ANSWER:
        return None, value
    inner = value.get("function", value.get("arguments", value.get("parameters")))
    if isinstance(inner, str):
        inner = next((obj for obj in _objects(inner) if isinstance(obj, dict)), None)
    if isinstance(inner, dict):
        name, found = _unwrapped(inner, depth + 1)
        outer_name = value.get("name")
        return name or (outer_name if isinstance(outer_name, str) else None), found
    if len(value) == 1:
        (name, only), *_ = value.items()
        if isinstance(only, dict) and only.keys() & OF_AN_ANSWER:
            return name, only
    return None, value


def _as_text(value: dict[str, Any]) -> str:
    try:
        return json.dumps(value, allow_nan=False)
    except (ValueError, RecursionError) as error:
        raise NoJsonError("the answer holds a number that is not finite, or is nested too deep") from error


def _objects(text: str) -> Iterator[Any]:
    """Yield every outermost JSON object in a text; trailing commas are accepted."""
    decoder = json.JSONDecoder()
    text = re.sub(r",(\s*[}\]])", r"\1", text) if not _is_json(text) else text
    at = text.find("{")
    while at >= 0:
        try:
            value, end = decoder.raw_decode(text, at)
            yield value
        except (ValueError, RecursionError):
            # A brace without valid JSON is part of the prose, so the search continues after it.
            end = at + 1
        at = text.find("{", end)


def _is_json(text: str) -> bool:
    try:
        json.loads(text)
    except (ValueError, RecursionError):
        return False
    return True
