"""Combines the words read on signs while the ego is stopped, and selects the next target.

A *look* is one reading of a target. A word counts after two looks.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from stucksolver.scene.signs import ObservedSign, SignWord
from stucksolver_perception.camera.sign_targets import SignTarget

MIN_AGREEING = 2
"""Number of looks with a word after which the word counts. The last look with any word must be one of them. Ours."""
MEMORY_LOOKS = 3
"""Number of last looks at a target that count. Ours."""
FORGET_S = 20.0
"""Time after which a word no longer counts (s): a flagger turns the paddle. Ours."""
REREAD_S = 5.0
"""Time after which a target with a word is read again, before other targets (s). Ours."""
SAME_SIGN_RAD = math.radians(4.0)
"""Maximum difference of direction between two readings of one sign (rad). Ours."""


@dataclass(frozen=True)
class WordLocation:
    """The location of a word."""

    bearing_rad: float
    """Direction relative to the heading (rad), positive to the left."""
    track_id: int | None = None
    """Id of the tracked object with the word; None without one."""


@dataclass(frozen=True)
class SignReadout:
    """The result of one look at a target, with each word once."""

    time_s: float
    target: SignTarget
    words: dict[SignWord, WordLocation]


@dataclass
class SignFilter:
    """The looks at each target since the ego stopped. Call `clear` when the ego moves."""

    _looks: dict[str, deque[SignReadout]] = field(default_factory=dict)
    _counts: Counter[str] = field(default_factory=Counter)
    _turn: int = 0

    def add(self, look: SignReadout) -> None:
        """Add a look. Looks must come in order of time."""
        self._looks.setdefault(look.target.key, deque(maxlen=MEMORY_LOOKS)).append(look)
        self._counts[look.target.key] += 1

    def count(self, target: SignTarget) -> int:
        """Return the number of looks at a target."""
        return self._counts[target.key]

    def clear(self) -> None:
        """Drop all looks."""
        self._looks.clear()
        self._counts.clear()

    def next_of(self, targets: Sequence[SignTarget], time_s: float) -> SignTarget | None:
        """Return the next target: the one that has not been read for the longest time.

        Every other call prefers targets whose word is unconfirmed or old.
        """
        if not targets:
            return None
        self._turn += 1
        due_targets = [target for target in targets if self._is_due(target, time_s)] if self._turn % 2 == 0 else []
        return min(due_targets or targets, key=lambda item: self._read_s(item))

    def signs(self, time_s: float) -> tuple[ObservedSign, ...]:
        """Return the words that count, once per direction, with the object that carries the word if there is one."""
        candidates = [item for looks in self._looks.values() for item in _confirmed_words(looks, time_s)]
        candidates.sort(key=lambda item: (item[1].object_id is None, item[1].distance_m is None, item[0]))
        signs: list[tuple[float, ObservedSign]] = []
        for bearing, sign in candidates:
            if all(
                sign.word != other.word or abs(bearing - other_bearing) > SAME_SIGN_RAD
                for other_bearing, other in signs
            ):
                signs.append((bearing, sign))
        return tuple(sign for _, sign in signs)

    def _read_s(self, target: SignTarget) -> float:
        looks = self._looks.get(target.key)
        return looks[-1].time_s if looks else -math.inf

    def _is_due(self, target: SignTarget, time_s: float) -> bool:
        looks = self._looks.get(target.key)
        if not looks or not any(look.words for look in looks):
            return False
        confirmed = bool(_confirmed_words(looks, time_s))
        return (bool(looks[-1].words) and not confirmed) or time_s - looks[-1].time_s >= REREAD_S


def _confirmed_words(looks: Sequence[SignReadout], time_s: float) -> list[tuple[float, ObservedSign]]:
    """Return the words of one target that count, each with its direction (rad)."""
    last = next((look for look in reversed(looks) if look.words), None)
    if last is None or time_s - last.time_s > FORGET_S:
        return []
    agreed = [word for word in last.words if sum(word in look.words for look in looks) >= MIN_AGREEING]
    return [(last.words[word].bearing_rad, _sign(last.target, word, last.words[word])) for word in agreed]


def _sign(target: SignTarget, word: SignWord, location: WordLocation) -> ObservedSign:
    if location.track_id is not None:
        return ObservedSign(word=word, object_id=str(location.track_id))
    distance_m = None if target.track_id is not None or target.distance_m is None else round(target.distance_m, 1)
    return ObservedSign(word=word, distance_m=distance_m, bearing_rad=round(location.bearing_rad, 3))
