"""Reads values that a language model wrote: JSON, or the notations that models write in its place.

Accepted besides JSON: Python's literals, keys without quotes, a comma before a closing bracket, and strings between the
marks of Gemma's models. Nothing is evaluated. Nesting and the number of characters read are bounded.
"""

from __future__ import annotations

import json
import re
from typing import Any, NamedTuple

DEEPEST = 32
"""Deepest nesting of a value. Ours: an answer has seven levels."""
MOST_READ = 400_000
"""Characters that a search for objects reads at most, including those read more than once. Ours."""
TOO_DEEP_READ = 8_000
"""Characters that count as read where the strict decoder ends at the interpreter's recursion limit. Ours."""
LONGEST_NUMBER = 40
WORDS = {"true": True, "false": False, "null": None, "True": True, "False": False, "None": None}
MARKS = ('<|"|>', "<escape>")
"""Marks around strings in the calls of Gemma's models."""
CLOSING = {"[": "]", "(": ")"}

_QUOTED = {quote: re.compile(rf"{quote}((?:[^{quote}\\]|\\.)*){quote}", re.DOTALL) for quote in "\"'"}
_KEY = re.compile(r"[A-Za-z_][\w.]{0,60}")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_SPACE = re.compile(r"\s*")
_DECODER = json.JSONDecoder()


class FoundObject(NamedTuple):
    """An object in a text, with its position and the position after it."""

    begin: int
    end: int
    value: dict[str, Any]


class NoValueError(ValueError):
    """There is no value here. `position` is the place at which reading ended."""

    def __init__(self, position: int) -> None:
        super().__init__("not a value")
        self.position = position


def read_value(text: str, at: int) -> tuple[Any, int]:
    """Return the value that begins at a position, and the position after it.

    Raises:
        NoValueError: There is no value at the position.
    """
    try:
        value: tuple[Any, int] = _DECODER.raw_decode(text, at)
        return value
    except RecursionError as error:
        raise NoValueError(at + TOO_DEEP_READ) from error
    except ValueError as error:
        # It may still be one of the other notations.
        return _read_leniently(text, at, getattr(error, "pos", at))


def _read_leniently(text: str, at: int, already: int) -> tuple[Any, int]:
    reader = _Reader(text, at)
    try:
        return reader.value(0), reader.at
    except NoValueError as error:
        raise NoValueError(max(error.position, already)) from error


def read_keywords(text: str, at: int) -> tuple[dict[str, Any], int]:
    """Return the keyword arguments of a Python call, which begin after its opening parenthesis.

    Raises:
        NoValueError: They are not literals, or the parenthesis is never closed.
    """
    reader = _Reader(text, at)
    return reader.pairs(")", "=", 0), reader.at


def whole_value(text: str) -> Any:
    """Return the value that a text consists of.

    Raises:
        NoValueError: The text is not one value.
    """
    stripped = text.strip()
    value, end = read_value(stripped, 0)
    if stripped[end:].strip():
        raise NoValueError(end)
    return value


def objects_in(text: str) -> list[FoundObject]:
    """Return every outermost object in a text. A brace that begins no object is part of the prose."""
    found = []
    left, at = MOST_READ, text.find("{")
    while at >= 0 and left > 0:
        value, end = _object_at(text, at)
        if value is None:
            left -= end - at + 1
            end = at + 1
        else:
            found.append(FoundObject(at, end, value))
        at = text.find("{", end)
    return found


def _object_at(text: str, at: int) -> tuple[dict[str, Any] | None, int]:
    """Return the object at a brace, or None, and the position at which reading ended."""
    try:
        return read_value(text, at)
    except NoValueError as error:
        return None, error.position


class _Reader:
    """Reads one value by recursive descent."""

    def __init__(self, text: str, at: int) -> None:
        self.text, self.at = text, at

    def value(self, depth: int) -> Any:
        if depth > DEEPEST:
            raise NoValueError(self.at)
        self._space()
        first = self.text[self.at : self.at + 1]
        if first == "{":
            self.at += 1
            return self.pairs("}", ":", depth)
        if first in CLOSING:
            self.at += 1
            return self._items(CLOSING[first], depth)
        text = self._string()
        return self._scalar() if text is None else text

    def pairs(self, closing: str, between: str, depth: int) -> dict[str, Any]:
        """Read the pairs of an object or of a call, up to the closing bracket."""
        found: dict[str, Any] = {}
        while not self._ends(closing):
            key = self._key()
            self._expect(between)
            found[key] = self.value(depth + 1)
            self._comma(closing)
        return found

    def _items(self, closing: str, depth: int) -> list[Any]:
        found = []
        while not self._ends(closing):
            found.append(self.value(depth + 1))
            self._comma(closing)
        return found

    def _ends(self, closing: str) -> bool:
        self._space()
        ends = self.text.startswith(closing, self.at)
        self.at += len(closing) if ends else 0
        return ends

    def _comma(self, closing: str) -> None:
        """Skip a comma. Only the closing bracket may follow without one."""
        self._space()
        if self.text.startswith(",", self.at):
            self.at += 1
        elif not self.text.startswith(closing, self.at):
            raise NoValueError(self.at)

    def _expect(self, sign: str) -> None:
        self._space()
        if not self.text.startswith(sign, self.at):
            raise NoValueError(self.at)
        self.at += len(sign)

    def _key(self) -> str:
        text = self._string()
        if text is not None:
            return text
        found = _KEY.match(self.text, self.at)
        if found is None:
            raise NoValueError(self.at)
        self.at = found.end()
        return found.group()

    def _string(self) -> str | None:
        """Read a string between quotes or marks; None if there is none."""
        for mark in MARKS:
            if self.text.startswith(mark, self.at):
                start = self.at + len(mark)
                end = self.text.find(mark, start)
                if end < 0:
                    raise NoValueError(len(self.text))
                self.at = end + len(mark)
                return self.text[start:end]
        quote = self.text[self.at : self.at + 1]
        if quote not in _QUOTED:
            return None
        found = _QUOTED[quote].match(self.text, self.at)
        if found is None:
            raise NoValueError(len(self.text))
        self.at = found.end()
        return _unescaped(found[1], quote)

    def _scalar(self) -> Any:
        found = _NUMBER.match(self.text, self.at) or _KEY.match(self.text, self.at)
        if found is None:
            raise NoValueError(self.at)
        word = found.group()
        if word in WORDS:
            self.at = found.end()
            return WORDS[word]
        if len(word) > LONGEST_NUMBER or word[0].isalpha() or word[0] == "_":
            raise NoValueError(self.at)
        self.at = found.end()
        return float(word) if re.search(r"[.eE]", word) else int(word)

    def _space(self) -> None:
        found = _SPACE.match(self.text, self.at)
        assert found is not None
        self.at = found.end()


def _unescaped(text: str, quote: str) -> str:
    """Return a string's text with its escapes resolved; unchanged if JSON does not know one of them."""
    if quote == "'":
        text = re.sub(r'\\(.)|"', _for_double_quotes, text, flags=re.DOTALL)
    try:
        resolved: str = json.loads(f'"{text}"', strict=False)
    except ValueError:
        # An escape of another language stays as it is.
        return text
    return resolved


def _for_double_quotes(found: re.Match[str]) -> str:
    if found[1] is None:
        return '\\"'
    return "'" if found[1] == "'" else found[0]
