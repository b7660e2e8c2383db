"""What was read where while the vehicle stands, and what is read next. A word counts after two looks at its place."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from stucksolver.scene.signs import ObservedSign, SignWord
from stucksolver_perception.camera.sign_targets import SignTarget

AGREE = 2
"""A word counts if so many ..."""
OF_LAST = 3
"""... of the last so many looks at its place found it, the last that found any word among them."""
FORGET_S = 20.0
"""A word that was last seen longer ago counts no more: a flagger turns the paddle."""
AGAIN_S = 5.0
"""A place where a word was found is read again after this time, before others."""
SAME_RAD = math.radians(4.0)
"""The same word in directions that differ by less is one sign."""


@dataclass(frozen=True)
class WordLocation:
    """Where a word was read."""

    bearing_rad: float
    """From the heading, to the left positive."""
    track_id: int | None = None
    """The tracked object that carries it."""


@dataclass(frozen=True)
class SignReadout:
    """What one look at a target found: each word once."""

    time_s: float
    target: SignTarget
    found: dict[SignWord, WordLocation]


@dataclass
class SignFilter:
    """The looks at each target since the vehicle has been standing. Call `clear` when it moves."""

    _looks: dict[str, deque[SignReadout]] = field(default_factory=dict)
    _counts: Counter[str] = field(default_factory=Counter)
    _turn: int = 0

    def add(self, look: SignReadout) -> None:
        """Add a look. Looks must come in order of time."""
        self._looks.setdefault(look.target.key, deque(maxlen=OF_LAST)).append(look)
        self._counts[look.target.key] += 1

    def count(self, target: SignTarget) -> int:
        """Return how often a target was looked at."""
        return self._counts[target.key]

    def clear(self) -> None:
        """Forget everything."""
        self._looks.clear()
        self._counts.clear()

    def next_of(self, targets: Sequence[SignTarget], time_s: float) -> SignTarget | None:
        """Return the target to be read next: the one that was not read for the longest time.

        Every other turn belongs to those whose word is unconfirmed or old.
        """
        if not targets:
            return None
        self._turn += 1
        due = [target for target in targets if self._is_due(target, time_s)] if self._turn % 2 == 0 else []
        return min(due or targets, key=lambda item: self._read_s(item))

    def signs(self, time_s: float) -> tuple[ObservedSign, ...]:
        """Return the words that count, each once in one direction, with its object if one carries it."""
        told = [item for looks in self._looks.values() for item in _counted(looks, time_s)]
        told.sort(key=lambda item: (item[1].object_id is None, item[1].distance_m is None, item[0]))
        kept: list[tuple[float, ObservedSign]] = []
        for bearing, sign in told:
            if all(sign.word != other.word or abs(bearing - near) > SAME_RAD for near, other in kept):
                kept.append((bearing, sign))
        return tuple(sign for _, sign in kept)

    def _read_s(self, target: SignTarget) -> float:
        looks = self._looks.get(target.key)
        return looks[-1].time_s if looks else -math.inf

    def _is_due(self, target: SignTarget, time_s: float) -> bool:
        looks = self._looks.get(target.key)
        if not looks or not any(look.found for look in looks):
            return False
        confirmed = bool(_counted(looks, time_s))
        return (bool(looks[-1].found) and not confirmed) or time_s - looks[-1].time_s >= AGAIN_S


def _counted(looks: Sequence[SignReadout], time_s: float) -> list[tuple[float, ObservedSign]]:
    """Return the words at one place, each with its direction (rad)."""
    last = next((look for look in reversed(looks) if look.found), None)
    if last is None or time_s - last.time_s > FORGET_S:
        return []
    agreed = [word for word in last.found if sum(word in look.found for look in looks) >= AGREE]
    return [(last.found[word].bearing_rad, _sign(last.target, word, last.found[word])) for word in agreed]


def _sign(target: SignTarget, word: SignWord, place: WordLocation) -> ObservedSign:
    if place.track_id is not None:
        return ObservedSign(word=word, object_id=str(place.track_id))
    away = None if target.track_id is not None or target.distance_m is None else round(target.distance_m, 1)
    return ObservedSign(word=word, distance_m=away, bearing_rad=round(place.bearing_rad, 3))
