"""Finds function calls that a model wrote into its text as tags or in Python's notation.

Models and servers differ in the names of the tags, not in their structure: an element for the function, and in it an
element for each argument. So the search goes by structure:

```text
<function=decide><parameter=decision>{…}</parameter></function>
<invoke name="decide"><parameter name="decision">{…}</parameter></invoke>
<tool_call>decide <arg_key>decision</arg_key><arg_value>{…}</arg_value></tool_call>
<decide><decision>{…}</decision></decide>
[decide(decision={…})]
```

The value of an argument may be JSON, or an element for each of its fields.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from stucksolver_language.llm.lenient_json import NoValueError, read_keywords, whole_value

PARTS = ("observation", "analysis", "decision", "behaviors", "choice", "S1", "S2", "why", "ready")
"""Arguments of our functions."""
MOST_PARTS = 64
"""Maximum number of arguments that are read from one text. Ours."""

MOST_CHILDREN = 64
"""Maximum number of elements in an element. Ours."""
DEEPEST_ELEMENT = 8
"""Deepest nesting of elements in an argument. Ours: an answer has six levels."""
ITEM = "item"
"""Element for an item of a list."""

_NOTATIONS = (
    (re.compile(r"<\|(?P<close>open|close)\|>\s?(?P<tag>[^<>]{1,200})<\|sep\|>"), None),
    (re.compile(r"<(/?)[｜|]\w{1,20}[｜|]\s?(?=\w)"), r"<\1"),
    (re.compile(r"\]<\]\w{1,20}\[>\["), ""),
)
"""Other notations of tags (Kimi K3, DeepSeek, MiniMax M3), with what stands for them in the usual one."""
_TAG = re.compile(
    r"<(?P<close>/)?(?P<name>[^\s<>/=]{1,60})(?:=(?P<value>[^\s<>]{1,80})|(?P<more>\s[^<>]{1,200}))?\s{0,20}>"
)
_NAME = re.compile(r"""\b(?:name|tool|key)\s{0,5}=\s{0,5}["']?([\w.\-]{1,80})""")
_BARE_NAME = re.compile(r"\s{0,20}([\w.\-]{1,80})\s{0,20}(?=<)")
_PYTHON = re.compile(rf"(?P<name>[\w.]{{1,80}})\s{{0,5}}\((?=\s{{0,20}}(?:{'|'.join(PARTS)})\s{{0,5}}=[^=])")
_ARGUMENT = frozenset({"parameter", "param", "arg", "argument"})
_FUNCTION = frozenset({"function", "invoke", "tool", "call"})
_END = re.compile(r"</(?:\w{1,20}:)?(?:function|invoke|tool_call)>")
_ELEMENTS = frozenset({*_ARGUMENT, *_FUNCTION, *PARTS, "tool_call", "arg_key", "arg_value"})
_BY_LOWER_CASE = {element.lower(): element for element in _ELEMENTS}


@dataclass(frozen=True)
class WrittenCall:
    """A call with its arguments. `name` is None if the text does not say which function is called."""

    name: str | None
    arguments: dict[str, Any] = field(default_factory=dict)


def with_usual_tags(text: str) -> str:
    """Return a text with the tags of all notations in the usual one."""
    for pattern, replacement in _NOTATIONS:
        text = pattern.sub(_usual if replacement is None else replacement, text)
    return text


def tagged_calls(text: str) -> list[WrittenCall]:
    """Return the calls that a text writes with tags."""
    calls: list[WrittenCall] = []
    for key, value in _tagged_parts(text):
        if value is None:
            calls.append(WrittenCall(plain_name(key)))
        else:
            if not calls or key in calls[-1].arguments:
                calls.append(WrittenCall(calls[-1].name if calls else None))
            calls[-1].arguments[key] = _value_of(value)
    return [call for call in calls if call.arguments]


def first_call(text: str, at: int) -> int:
    """Return where the first argument in a tag or the first call in Python's notation begins; the end without one."""
    python = _PYTHON.search(text, at)
    end = len(text) if python is None else python.start()
    while (tag := _TAG.search(text, at, end)) is not None:
        element, at = _element_of(tag["name"]), tag.end()
        if not tag["close"] and (element in PARTS or element in _ARGUMENT or element == "arg_key"):
            return tag.start()
    return end


def written_calls(text: str) -> list[WrittenCall]:
    """Return the calls in the notation that begins first. The other one in its arguments is part of their texts."""
    python = _PYTHON.search(text)
    if python is not None and first_call(text, 0) == python.start():
        return python_calls(text)
    return tagged_calls(text)


def python_calls(text: str) -> list[WrittenCall]:
    """Return the calls that a text writes in Python's notation, with literals as keyword arguments."""
    calls: list[WrittenCall] = []
    at = 0
    while (found := _PYTHON.search(text, at)) is not None and len(calls) < MOST_PARTS:
        call, at = _python_call(text, found)
        calls += [] if call is None else [call]
    return calls


def _python_call(text: str, found: re.Match[str]) -> tuple[WrittenCall | None, int]:
    """Return a call and the position after it; None if its arguments are not literals."""
    try:
        arguments, end = read_keywords(text, found.end())
    except NoValueError as error:
        # What was read up to here is prose.
        return None, max(error.position, found.end())
    return WrittenCall(plain_name(found["name"]), arguments), end


def plain_name(name: str) -> str:
    """Return a function's name without a module, a number or a special token, as in `functions.decide:0`."""
    found = re.match(r"(?:\w{1,80}\.)*(\w{1,80})", name.strip())
    return found[1] if found else ""


def _tagged_parts(text: str) -> Iterator[tuple[str, str | None]]:
    """Yield each argument with its text, and each function's name with None, in the order of the text."""
    at, key, count = 0, None, 0
    while (tag := _TAG.search(text, at)) is not None and count < MOST_PARTS:
        at = tag.end()
        if tag["close"]:
            continue
        element = _element_of(tag["name"])
        named = tag["value"] or _attribute(tag["more"])
        if element in _FUNCTION and named:
            yield named.strip("\"'"), None
        elif element == "tool_call" and (bare := _BARE_NAME.match(text, at)):
            yield bare[1], None
        elif element == "arg_key":
            key, at = _content(text, tag)
        elif (element in _ARGUMENT and named) or (element == "arg_value" and key) or element in PARTS:
            count += 1
            content, at = _content(text, tag)
            yield (named or key or "").strip("\"' ") if element not in PARTS else element, content


def _usual(tag: re.Match[str]) -> str:
    return f"<{'/' if tag['close'] == 'close' else ''}{tag['tag'].strip()}>"


def _element_of(name: str) -> str:
    """Return the name of an element without a namespace before it or a suffix after it."""
    parts = name.lower().split(":")
    return next((_BY_LOWER_CASE[part] for part in parts if part in _BY_LOWER_CASE), parts[-1])


def _attribute(more: str | None) -> str | None:
    found = _NAME.search(more or "")
    return found[1] if found else None


def _content(text: str, tag: re.Match[str]) -> tuple[str, int]:
    """Return the text of an element and the position after it. An element that is not closed ends before the next."""
    name = re.escape(tag["name"])
    at, depth = tag.end(), 1
    for mark in re.compile(rf"<(?P<close>/)?{name}(?P<more>[=\s][^<>]{{0,200}})?\s{{0,20}}>").finditer(text, at):
        if mark["more"] and not mark["close"]:
            # The next argument begins, so that this one was not closed.
            return text[at : mark.start()], mark.start()
        depth += -1 if mark["close"] else 1
        if depth == 0:
            return text[at : mark.start()], mark.end()
    end = _END.search(text, at)
    return (text[at:], len(text)) if end is None else (text[at : end.start()], end.start())


def _value_of(text: str, depth: int = 0) -> Any:
    """Return the value in an argument: JSON or another notation of values, elements for its fields, or a text."""
    try:
        return whole_value(text)
    except NoValueError:
        # It is no value of any notation.
        children = _children(text) if depth < DEEPEST_ELEMENT else []
    if not children:
        return text.strip()
    values = [(key, _value_of(content, depth + 1)) for key, content in children]
    return [value for _, value in values] if all(key == ITEM for key, _ in values) else dict(values)


def _children(text: str) -> list[tuple[str, str]]:
    """Return the elements of which a text consists, with their texts; none if there is anything else between them."""
    children: list[tuple[str, str]] = []
    at = 0
    while tag := _TAG.match(text, at + len(text[at:]) - len(text[at:].lstrip())):
        content, at = _content(text, tag)
        children.append((tag["name"], content))
        if tag["close"] or len(children) > MOST_CHILDREN:
            return []
    return [] if text[at:].strip() else children
