"""Makes a server's text safe to display and store: removes control sequences and keys."""

from __future__ import annotations

import json
import re
import unicodedata
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from stucksolver.privacy.url_redaction import HIDDEN, redacted
from stucksolver_language.llm.api_keys import secrets_here
from stucksolver_language.llm.chat import ChatReply, ToolCall

SEQUENCE = re.compile(
    r"(?:\x1b\[|\x9b)[0-?]*[ -/]*[@-~]|(?:\x1b[\]PX^_]|[\x90\x98\x9d-\x9f])[^\x07\x1b\x9c]*(?:\x07|\x1b\\|\x9c)?|\x1b."
)
"""Control sequences of terminals with their parameters (ECMA-48)."""
ESCAPE = re.compile(r"(?<!\\)((?:\\\\)*)\\u([0-9a-fA-F]{4})")
"""A character as an escape sequence of JSON."""
LINE_CONTROLS = "\n\t"
INVISIBLE = frozenset({"Cc", "Cf", "Zl", "Zp"})
"""Unicode categories that are removed. They move the cursor, reverse the direction, or split a word invisibly."""
HALVES = re.compile("[\ud800-\udfff]")
"""Halves of characters, which no file can store. They are replaced, so that the record shows where one was."""


def printable(text: str) -> str:
    """Return a text without control sequences and invisible characters. Line breaks and tabs stay."""
    text = HALVES.sub("\N{REPLACEMENT CHARACTER}", SEQUENCE.sub("", text))
    return "".join(c for c in text if c in LINE_CONTROLS or unicodedata.category(c) not in INVISIBLE)


def clean(text: str, secrets: Iterable[str] = ()) -> str:
    """Return a server's text for people.

    The text is printable and contains no logins of URLs, no keys from the environment and none of the `secrets`.
    """
    text = printable(text)
    for secret in sorted({*secrets, *secrets_here()}, key=len, reverse=True):
        text = text.replace(secret, HIDDEN)
    return redacted(text)


def clean_reply(reply: ChatReply, secrets: Iterable[str] = ()) -> ChatReply:
    """Return a reply with every text cleaned, also in JSON that writes characters as escape sequences.

    `raw` is expected to be clean.
    """
    known = tuple(secrets)
    calls = tuple(
        ToolCall(clean(c.id, known), clean(c.name, known), clean_json(c.arguments, known), _clean_value(c.extra, known))
        for c in reply.calls
    )
    return replace(
        reply,
        text=clean_json(reply.text, known),
        calls=calls,
        model=clean(reply.model, known),
        thoughts=clean_json(reply.thoughts, known),
        extra=_clean_value(reply.extra, known),
    )


def clean_json(text: str, secrets: tuple[str, ...]) -> str:
    """Return a text cleaned, also where it is JSON that writes characters as escape sequences."""
    try:
        value = json.loads(text)
        cleaned = _clean_value(value, secrets)
    except (ValueError, RecursionError):
        # Text that is no JSON is cleaned as plain text.
        return clean(ESCAPE.sub(_unescaped, text), secrets)
    return clean(text, secrets) if cleaned == value else json.dumps(cleaned, ensure_ascii=False)


def _unescaped(found: re.Match[str]) -> str:
    """Return an escaped character unescaped, unless JSON requires the escape."""
    character = chr(int(found[2], 16))
    if character in '"\\\n\t' or 0xD800 <= ord(character) <= 0xDFFF:
        return found[0]
    return found[1] + character


def _clean_value(value: Any, secrets: tuple[str, ...]) -> Any:
    if isinstance(value, str):
        return clean(value, secrets)
    if isinstance(value, list):
        return [_clean_value(item, secrets) for item in value]
    if isinstance(value, dict):
        return {clean(str(key), secrets): _clean_value(item, secrets) for key, item in value.items()}
    return value
