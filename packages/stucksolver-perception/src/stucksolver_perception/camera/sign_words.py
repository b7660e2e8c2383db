"""Compares what a text recognizer read with a fixed list of words. Nothing but words of the list leaves this module.

Text on signs is untrusted, so free text must never reach a language model's prompt. A plate counts as a whole: STOP
AHEAD is not STOP. Speeds are not on the list, because a misread speed is worse than none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stucksolver.scene.signs import SignWord

PLATES: dict[SignWord, tuple[str, ...]] = {
    SignWord.STOP: ("STOP", "STOP ALL WAY"),
    SignWord.YIELD: ("YIELD",),
    SignWord.SLOW: ("SLOW",),
    SignWord.ROAD_CLOSED: ("ROAD CLOSED",),
    SignWord.DETOUR: ("DETOUR",),
    SignWord.ROAD_WORK: ("ROAD WORK", "ROAD WORK AHEAD"),
    SignWord.DO_NOT_ENTER: ("DO NOT ENTER",),
    SignWord.SCHOOL_BUS: ("SCHOOL BUS",),
    SignWord.POLICE: ("POLICE",),
    SignWord.AMBULANCE: ("AMBULANCE",),
    SignWord.FIRE: ("FIRE",),
}
"""The texts of whole plates that stand for each word."""
ALIKE = ("OCDQ0", "I1LJT", "S5", "B8", "Z2", "VY", "G6", "A4")
"""Letters and digits that recognizers confuse with each other: equal in the comparison."""
SURE = 0.6
"""The least confidence of each line of a plate."""
ONE_EDIT_FROM = 7
"""Number of letters from which a word may differ by one letter: FIELD is not YIELD, POLICY not POLICE."""
TWO_EDITS_FROM = 9
"""The same for two letters."""
SPARE = frozenset({SignWord.DETOUR})
"""Shorter words that may differ by a letter, since no other word of English does."""
LINE_GAP = 0.9
"""Largest gap between two lines of one plate, in heights of the smaller one."""
LINE_OVERLAP = 0.4
"""Least overlap of such lines, as a share of the narrower one; or of the lower one, if they stand side by side."""
SPACE_GAP = 1.2
"""Largest gap between two pieces of one line, in heights of the smaller one."""
SIZE_RATIO = 2.5
"""The heights of lines of one plate differ by at most this factor."""


@dataclass(frozen=True)
class TextLine:
    """A line of text in an image, as read: untrusted."""

    text: str
    confidence: float
    left: float
    top: float
    right: float
    bottom: float
    """Its rectangle (px)."""


@dataclass(frozen=True)
class DetectedWord:
    """A word of the list, and the middle of its plate in the image (px)."""

    word: SignWord
    column: float
    row: float


def words_of(lines: Sequence[TextLine]) -> tuple[DetectedWord, ...]:
    """Return the words of the list that whole plates show."""
    found = []
    for plate in plates_of([line for line in lines if _plain(line.text)]):
        word = word_of("".join(line.text for line in plate))
        if word is not None and min(line.confidence for line in plate) >= SURE:
            column = (min(line.left for line in plate) + max(line.right for line in plate)) / 2.0
            row = (min(line.top for line in plate) + max(line.bottom for line in plate)) / 2.0
            found.append(DetectedWord(word, column, row))
    return tuple(found)


def word_of(text: str) -> SignWord | None:
    """Return the word of the list whose plate has this text, but for the allowed errors; None if there is none."""
    read = _folded(_plain(text))
    close = [(_edits(read, shape, most), word) for shape, word, most in _SHAPES if abs(len(read) - len(shape)) <= most]
    best = min(((edits, word) for edits, word in close if edits is not None), default=None, key=lambda item: item[0])
    return None if best is None else best[1]


def plates_of(lines: Sequence[TextLine]) -> list[list[TextLine]]:
    """Return the lines in groups, one per plate, each in the order of reading."""
    groups: list[list[TextLine]] = []
    for line in sorted(lines, key=lambda line: line.top):
        beside = [group for group in groups if any(_belong(line, other) for other in group)]
        joined = [line, *(other for group in beside for other in group)]
        groups = [group for group in groups if group not in beside] + [joined]
    return [_in_order(group) for group in groups]


def _in_order(group: list[TextLine]) -> list[TextLine]:
    """Return the lines of a plate from top to bottom, and those side by side from left to right."""
    rows: list[list[TextLine]] = []
    for line in sorted(group, key=lambda item: item.top + item.bottom):
        middle = (line.top + line.bottom) / 2.0
        if rows and rows[-1][0].top < middle < rows[-1][0].bottom:
            rows[-1].append(line)
        else:
            rows.append([line])
    return [line for row in rows for line in sorted(row, key=lambda item: item.left)]


def _belong(first: TextLine, second: TextLine) -> bool:
    heights = sorted((first.bottom - first.top, second.bottom - second.top))
    if heights[1] > SIZE_RATIO * heights[0]:
        return False
    across = min(first.right, second.right) - max(first.left, second.left)
    along = min(first.bottom, second.bottom) - max(first.top, second.top)
    if across >= LINE_OVERLAP * min(first.right - first.left, second.right - second.left):
        return -along <= LINE_GAP * heights[0]
    return along >= LINE_OVERLAP * heights[0] and -across <= SPACE_GAP * heights[0]


def _plain(text: str) -> str:
    """Return letters and digits. Those of other scripts stay as `?`, so that such a text is no word of the list."""
    return "".join(letter if letter.isascii() else "?" for letter in text.upper() if letter.isalnum())


_FOLD = {ord(letter): group[0] for group in ALIKE for letter in group}


def _folded(text: str) -> str:
    return text.translate(_FOLD)


def _most_edits(word: SignWord, letters: int) -> int:
    if letters >= TWO_EDITS_FROM:
        return 2
    return int(letters >= ONE_EDIT_FROM or word in SPARE)


_SHAPES = tuple(
    (_folded(_plain(plate)), word, _most_edits(word, len(_plain(plate))))
    for word, some in PLATES.items()
    for plate in some
)


def _edits(read: str, wanted: str, most: int) -> int | None:
    """Return the edit distance; None if it is above `most`."""
    row = list(range(len(wanted) + 1))
    for i, letter in enumerate(read, 1):
        before, row[0] = row[0], i
        for j, other in enumerate(wanted, 1):
            before, row[j] = row[j], min(row[j] + 1, row[j - 1] + 1, before + (letter != other))
    return row[-1] if row[-1] <= most else None
