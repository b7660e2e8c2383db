"""Compares text from a text recognizer with a fixed list of words. Only words of the list leave this module.

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
"""The texts of whole plates for each word."""
CONFUSED_LETTERS = ("OCDQ0", "I1LJT", "S5", "B8", "Z2", "VY", "G6", "A4")
"""Letters and digits that recognizers confuse. They are equal in the comparison. Ours."""
MIN_CONFIDENCE = 0.6
"""Minimum confidence of each line of a plate. Ours."""
ONE_EDIT_FROM = 7
"""Minimum number of letters of a word that may differ by one letter: FIELD is not YIELD, POLICY is not POLICE. Ours."""
TWO_EDITS_FROM = 9
"""Minimum number of letters of a word that may differ by two letters. Ours."""
DISTINCT_WORDS = frozenset({SignWord.DETOUR})
"""Shorter words that may differ by a letter, because no other English word is that similar."""
LINE_GAP = 0.9
"""Maximum gap between two lines of one plate, in heights of the smaller one. Ours."""
LINE_OVERLAP = 0.4
"""Minimum overlap of two such lines, as a share of the narrower one; of the lower one for pieces side by side. Ours."""
SPACE_GAP = 1.2
"""Maximum gap between two pieces of one line, in heights of the smaller one. Ours."""
SIZE_RATIO = 2.5
"""Maximum ratio of the heights of two lines of one plate. Ours."""


@dataclass(frozen=True)
class TextLine:
    """A line of text in an image, as recognized and untrusted. Its rectangle is in px."""

    text: str
    confidence: float
    left: float
    top: float
    right: float
    bottom: float


@dataclass(frozen=True)
class DetectedWord:
    """A word of the list, and the center of its plate in the image (px)."""

    word: SignWord
    column: float
    row: float


def words_of(lines: Sequence[TextLine]) -> tuple[DetectedWord, ...]:
    """Return the words of the list on whole plates."""
    words = []
    for plate in plates_of([line for line in lines if _plain(line.text)]):
        word = word_of("".join(line.text for line in plate))
        if word is not None and min(line.confidence for line in plate) >= MIN_CONFIDENCE:
            column = (min(line.left for line in plate) + max(line.right for line in plate)) / 2.0
            row = (min(line.top for line in plate) + max(line.bottom for line in plate)) / 2.0
            words.append(DetectedWord(word, column, row))
    return tuple(words)


def word_of(text: str) -> SignWord | None:
    """Return the word of the list whose plate has this text, with the allowed errors; None without one."""
    text_read = _folded(_plain(text))
    close = [
        (_edits(text_read, shape, max_edits), word)
        for shape, word, max_edits in _SHAPES
        if abs(len(text_read) - len(shape)) <= max_edits
    ]
    best = min(((edits, word) for edits, word in close if edits is not None), default=None, key=lambda item: item[0])
    return None if best is None else best[1]


def plates_of(lines: Sequence[TextLine]) -> list[list[TextLine]]:
    """Return the lines in groups, one per plate, each in the order of reading."""
    groups: list[list[TextLine]] = []
    for line in sorted(lines, key=lambda line: line.top):
        neighbors = [group for group in groups if any(_are_on_one_plate(line, other) for other in group)]
        joined_lines = [line, *(other for group in neighbors for other in group)]
        groups = [group for group in groups if group not in neighbors] + [joined_lines]
    return [_in_order(group) for group in groups]


def _in_order(group: list[TextLine]) -> list[TextLine]:
    """Return the lines of a plate from top to bottom, and pieces side by side from left to right."""
    rows: list[list[TextLine]] = []
    for line in sorted(group, key=lambda item: item.top + item.bottom):
        center = (line.top + line.bottom) / 2.0
        if rows and rows[-1][0].top < center < rows[-1][0].bottom:
            rows[-1].append(line)
        else:
            rows.append([line])
    return [line for row in rows for line in sorted(row, key=lambda item: item.left)]


def _are_on_one_plate(first: TextLine, second: TextLine) -> bool:
    heights = sorted((first.bottom - first.top, second.bottom - second.top))
    if heights[1] > SIZE_RATIO * heights[0]:
        return False
    across = min(first.right, second.right) - max(first.left, second.left)
    along = min(first.bottom, second.bottom) - max(first.top, second.top)
    if across >= LINE_OVERLAP * min(first.right - first.left, second.right - second.left):
        return -along <= LINE_GAP * heights[0]
    return along >= LINE_OVERLAP * heights[0] and -across <= SPACE_GAP * heights[0]


def _plain(text: str) -> str:
    """Return the letters and digits. Those of other scripts become `?`, so that such a text is no word of the list."""
    return "".join(letter if letter.isascii() else "?" for letter in text.upper() if letter.isalnum())


_FOLD = {ord(letter): group[0] for group in CONFUSED_LETTERS for letter in group}


def _folded(text: str) -> str:
    return text.translate(_FOLD)


def _most_edits(word: SignWord, letters: int) -> int:
    if letters >= TWO_EDITS_FROM:
        return 2
    return int(letters >= ONE_EDIT_FROM or word in DISTINCT_WORDS)


_SHAPES = tuple(
    (_folded(_plain(plate)), word, _most_edits(word, len(_plain(plate))))
    for word, plates in PLATES.items()
    for plate in plates
)


def _edits(text_read: str, expected: str, max_edits: int) -> int | None:
    """Return the edit distance; None if it is above `max_edits`."""
    row = list(range(len(expected) + 1))
    for i, letter in enumerate(text_read, 1):
        diagonal, row[0] = row[0], i
        for j, other in enumerate(expected, 1):
            diagonal, row[j] = row[j], min(row[j] + 1, row[j - 1] + 1, diagonal + (letter != other))
    return row[-1] if row[-1] <= max_edits else None
