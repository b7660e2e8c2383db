"""Separates the thoughts of a reasoning model from its answer, where a server leaves both in one text."""

from __future__ import annotations

import re
from collections.abc import Iterator

from stucksolver_language.llm.lenient_json import objects_in

_NAMES = r"think|thinking|thoughts?|reasoning|scratch_?pad"
_MARK = re.compile(
    rf"[<\[◁]\|?(?P<close>/|END_)?(?:START_|content_)?(?:\w{{1,20}}:)?(?:{_NAMES})\|?[>\]▷]"
    r"|(?P<channel><\|channel\|?>\s?(?:analysis|thought))"
    r"|(?P<end><\|end(?:_message)?\|>|<\|start\|>|<channel\|>)",
    re.IGNORECASE,
)
"""Marks such as `<think>`, `</think>`, `[THINK]` and `<|START_THINKING|>`, and the channels of gpt-oss and Gemma 4."""


def split_thoughts(text: str) -> tuple[str, str]:
    """Return the answer and the thoughts in a text. Marks inside an object belong to its texts.

    Thoughts whose mark is never closed last to the end. Text before a closing mark without an opening one is thoughts:
    chat templates often write the opening mark themselves.
    """
    answer: list[str] = []
    thoughts: list[str] = []
    thinking, at = False, 0
    for mark in _marks(text):
        part, opens = text[at : mark.start()], not (mark["close"] or mark["end"])
        if mark["end"] and not thinking:
            continue
        (thoughts if thinking else answer).append(part)
        if mark["close"] and not thinking:
            thoughts += answer
            answer = []
        thinking, at = opens, mark.end()
    (thoughts if thinking else answer).append(text[at:])
    return "".join(answer), "\n".join(thoughts)


def _marks(text: str) -> Iterator[re.Match[str]]:
    objects = objects_in(text) if _MARK.search(text) else []
    at = 0
    for mark in _MARK.finditer(text):
        while at < len(objects) and objects[at].end <= mark.start():
            at += 1
        if at == len(objects) or mark.start() < objects[at].begin:
            yield mark
