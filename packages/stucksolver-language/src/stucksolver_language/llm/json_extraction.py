"""Extracts the single call or JSON object from a model's text and ignores the rest."""

from __future__ import annotations

import json
import re
from functools import lru_cache
from typing import Any

from stucksolver_language.llm.lenient_json import DEEPEST, NoValueError, objects_in, whole_value
from stucksolver_language.llm.thoughts import split_thoughts
from stucksolver_language.llm.tool_schema import CHECK_PLAN, DECIDE
from stucksolver_language.llm.written_calls import (
    PARTS,
    WrittenCall,
    first_call,
    plain_name,
    with_usual_tags,
    written_calls,
)

MOST_CHARACTERS = 40_000
"""Longest answer that is read (characters), without thoughts. Ours: about 25 times a normal answer."""
MOST_WITH_THOUGHTS = 1_000_000
"""Longest text in which thoughts are separated from the answer (characters). Ours."""
OF_AN_ANSWER = frozenset({"decision", "behaviors", "choice", "ready"})
DEEPEST_WRAPPING = 6
"""Deepest nesting of objects, lists and encoded texts around the arguments that is unwrapped. Ours."""
NAMES = ("name", "tool_name", "tool", "recipient_name", "action", "function")
"""Fields that name the function of a call written as an object."""
NESTED = re.compile(
    r"observation|analysis|decision|steps|controls|participants|signs|picture_only|behaviors|S1|S\d\.\d"
)
"""Fields that hold an object or a list. A text in their place is JSON that was encoded twice."""
SURROGATES = re.compile("[\ud800-\udfff]")
"""Halves of characters. No file can store them."""


class NoJsonError(ValueError):
    """There is no JSON object, or more than one. The message can be quoted to the model."""


def extract_json(text: str) -> str:
    """Return the object as JSON text. Prose, thoughts, code fences and a call around it are ignored.

    Raises:
        NoJsonError: There is no object, or more than one.
    """
    try:
        return json.dumps(extract_call(text).arguments, allow_nan=False)
    except (ValueError, RecursionError) as error:
        if isinstance(error, NoJsonError):
            raise
        raise NoJsonError("the answer holds a number that is not finite, or is nested too deep") from error


def extract_call(text: str) -> WrittenCall:
    """Return the one call in a text.

    The same call twice counts as one. A decision together with queries to the guard is the decision.

    Raises:
        NoJsonError: There is no object, or there are several different ones.
    """
    calls = find_calls(text)
    decisions = tuple(call for call in calls if not asks_guard(call))
    calls = decisions or calls
    if not calls:
        raise NoJsonError("the answer holds no JSON object")
    if len(calls) > 1:
        raise NoJsonError("the answer holds more than one JSON object; give one")
    return calls[0]


@lru_cache(maxsize=16)
def find_calls(text: str) -> tuple[WrittenCall, ...]:
    """Return the different calls in a text; if there are none, the different objects.

    The answer counts before the thoughts. The same reply is searched several times, so the result is kept.

    Raises:
        NoJsonError: The text is too long, or a call is nested too deep.
    """
    if len(text) > MOST_WITH_THOUGHTS:
        raise NoJsonError(f"the answer is longer than {MOST_WITH_THOUGHTS} characters")
    text = _decoded_text(text)
    answer, thoughts = (text, "") if _is_json(text) else split_thoughts(with_usual_tags(text))
    if len(answer) > MOST_CHARACTERS:
        raise NoJsonError(f"the answer is longer than {MOST_CHARACTERS} characters")
    parts = [_decoded_text(part) for part in (answer, thoughts[-MOST_CHARACTERS:]) if part.strip()]
    found = [_calls_in(part) for part in parts]
    for calls in found:
        answers = [call for call in calls if call.arguments.keys() & OF_AN_ANSWER]
        if answers:
            return tuple(_different(answers))
    return tuple(_different([call for calls in found for call in calls]))


def holds_answer(text: str) -> bool:
    """True if a text holds arguments of one of our functions."""
    try:
        return any(call.arguments.keys() & OF_AN_ANSWER for call in find_calls(text))
    except NoJsonError:
        # What cannot be read holds no answer.
        return False


def asks_guard(call: WrittenCall) -> bool:
    """True for a call that queries the guard. Without a known name, its arguments tell."""
    if call.name in (DECIDE, CHECK_PLAN):
        return call.name == CHECK_PLAN
    return call.arguments.keys() == {"behaviors"}


def _calls_in(text: str) -> list[WrittenCall]:
    """Return the calls in a text, or its objects.

    A call that an object quotes in its texts is no call. An object after the beginning of a call belongs to its
    arguments.
    """
    found: list[WrittenCall] = []
    at, first = 0, first_call(text, 0)
    for item in objects_in(text):
        first = first_call(text, at) if first < at else first
        if first < item.begin:
            break
        found += _unwrapped(item.value, None, 0) or [WrittenCall(None, item.value)]
        at = item.end
    rest = text[at:]
    answers = [call for call in written_calls(rest) if call.arguments.keys() & OF_AN_ANSWER]
    found += answers
    for item in objects_in(rest) if not answers else ():
        found += _unwrapped(item.value, None, 0) or [WrittenCall(None, item.value)]
    return [WrittenCall(call.name, _sound(call.arguments)) for call in found]


def _unwrapped(value: Any, name: str | None, depth: int) -> list[WrittenCall]:
    """Return the arguments of our functions inside a value, with the name of the innermost call around them."""
    if isinstance(value, str) and "{" in value and len(value) <= MOST_CHARACTERS:
        value = [item.value for item in objects_in(value)]
    if isinstance(value, dict) and value.keys() & set(PARTS):
        # The texts of an incomplete answer are not searched for another one.
        return [WrittenCall(name, value)] if value.keys() & OF_AN_ANSWER else []
    if depth == DEEPEST_WRAPPING:
        return []
    if isinstance(value, list):
        return [call for item in value for call in _unwrapped(item, name, depth + 1)]
    if not isinstance(value, dict):
        return []
    name = _name_of(value) or name
    return [
        call
        for key, item in value.items()
        if isinstance(item, dict | list | str)
        for call in _unwrapped(item, key if len(value) == 1 and name is None else name, depth + 1)
    ]


def _name_of(value: dict[str, Any]) -> str | None:
    return next((plain_name(value[key]) for key in NAMES if isinstance(value.get(key), str)), None)


def _is_json(text: str) -> bool:
    """True if a text is JSON and nothing else, so that marks in it belong to its texts."""
    try:
        json.loads(text)
    except (ValueError, RecursionError):
        return False
    return True


def _different(calls: list[WrittenCall]) -> list[WrittenCall]:
    different: list[WrittenCall] = []
    for call in calls:
        if all(call.arguments != other.arguments or asks_guard(call) != asks_guard(other) for other in different):
            different.append(call)
    return different


def _decoded_text(text: str) -> str:
    """Return a text that was encoded as a JSON string as it was before."""
    for _ in range(DEEPEST_WRAPPING):
        if not text.lstrip().startswith('"'):
            break
        try:
            value = whole_value(text)
        except NoValueError:
            # The quote belongs to prose.
            break
        if not isinstance(value, str):
            break
        text = value
    return text


def _sound(value: Any, nested: bool = False, depth: int = 0) -> Any:
    """Return a value without halves of characters, and with objects and lists that were encoded as text decoded.

    Raises:
        NoJsonError: The value is nested too deep.
    """
    if depth > DEEPEST:
        raise NoJsonError("the answer is nested too deep")
    if isinstance(value, str):
        decoded = _decoded(value) if nested else value
        return SURROGATES.sub("�", decoded) if isinstance(decoded, str) else _sound(decoded, False, depth + 1)
    if isinstance(value, list):
        return [_sound(item, nested, depth + 1) for item in value]
    if isinstance(value, dict):
        return {
            SURROGATES.sub("�", key): _sound(item, NESTED.fullmatch(key) is not None, depth + 1)
            for key, item in value.items()
        }
    return value


def _decoded(text: str) -> Any:
    """Return the object or list that a text encodes, otherwise the text. An element without items is an empty list."""
    if not text.strip():
        return []
    try:
        value = whole_value(_decoded_text(text))
    except NoValueError:
        # The strict parser reports the text.
        return text
    return value if isinstance(value, dict | list) or value is None else text
