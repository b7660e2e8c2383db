"""What is known of each tracked object after several looks: kinds are voted on, blinkers need time."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stucksolver.scene.objects import PASSABLE_KINDS, Gesture, ObjectKind
from stucksolver_perception.camera.crop_network import KINDS, NOTHING, softmax
from stucksolver_perception.measurements import Floats


@dataclass(frozen=True, eq=False)
class Attributes:
    """What is known of one object; None for everything that is not certain enough."""

    kind: ObjectKind | None = None
    kind_confidence: float = 0.0
    """Confidence of the likeliest kind, reported or not; 0 if the object was not looked at."""
    kind_shares: Floats | None = None
    """(len(KINDS),) probabilities, for voting; None if the object was not looked at."""
    hidden: bool | None = None
    """True: the box shows something else, or nothing."""
    brake_lights: bool | None = None
    left_blinker: bool | None = None
    """In a single image: whether it is lit now. In a memory: whether it blinks."""
    right_blinker: bool | None = None
    emergency_lights: bool | None = None
    door_open: bool | None = None
    gesture: Gesture | None = None
    """Of a flagger; None for all others."""

    @property
    def hazard_lights(self) -> bool | None:
        """True if both blinkers blink; False as soon as one is known to be off."""
        both = (self.left_blinker, self.right_blinker)
        return False if False in both else (True if all(both) else None)


LOOKS = 2
"""A kind is reported after this many looks that were each sure of it."""
VOTED, PASSABLE_VOTED = 0.9, 0.99
"""Share of the vote that a kind needs; a kind that may be driven over needs more."""
LOOK_WEIGHT = 0.5
"""Looks at the same object are correlated: each counts as half an independent look."""
LOOK_CAP, VOTE_CAP = 4.0, 9.0
"""How far one look, and all looks together, can put a kind behind the likeliest (nats), so that a vote can be
overturned.
"""
BLINK_S = 1.5
"""Two periods of the slowest common blinkers, minus the time that they are lit (s)."""
BLINK_LOOKS, BLINK_LEAST_S = 3, 0.9
"""A blinker is off if this many looks over at least this long all saw it dark."""
BRAKE_S = 0.6
"""How long a look at the brake lamps is valid."""
AGREE = 2
"""Emergency lights, doors and gestures are reported if this many of the last three usable looks agree."""
SLOW = ("emergency_lights", "door_open", "gesture")
"""What changes slowly, in the order of the last fields of `Attributes`."""
_NOTHING = KINDS.index(NOTHING)


@dataclass
class _AttributeHistory:
    votes: Floats = field(default_factory=lambda: np.zeros(_NOTHING))
    said: Counter[ObjectKind] = field(default_factory=Counter)
    looks: deque[tuple[float, Attributes]] = field(default_factory=deque)
    """The looks of the last `BLINK_S`, oldest first."""
    slow: dict[str, deque[Any]] = field(default_factory=dict)
    """The last three answers for what changes slowly, by name."""


class AttributeFilter:
    """Combines the looks at each track over time."""

    def __init__(self) -> None:
        self._known: dict[int, _AttributeHistory] = {}

    def add(self, track_id: int, look: Attributes, time_s: float) -> None:
        """Add a look at a track. Looks must come in order of time."""
        if look.kind_shares is None:
            return
        known = self._known.setdefault(track_id, _AttributeHistory())
        _vote(known, look)
        if not known.looks or time_s - known.looks[-1][0] > BLINK_S:
            known.slow.clear()
        known.looks.append((time_s, look))
        for name in SLOW:
            answer = getattr(look, name)
            if answer is not None:
                known.slow.setdefault(name, deque(maxlen=3)).append(answer)

    def get(self, track_id: int, time_s: float) -> Attributes | None:
        """Return what is known of a track at a time; None if the camera never saw it."""
        known = self._known.get(track_id)
        if known is None:
            return None
        while known.looks and time_s - known.looks[0][0] > BLINK_S:
            known.looks.popleft()
        kind, sure, shares = _kind(known)
        recent = list(known.looks)
        last = recent[-1][1] if recent else Attributes()
        brake = [item.brake_lights for at, item in recent if time_s - at <= BRAKE_S and item.brake_lights is not None]
        return Attributes(
            kind,
            sure,
            shares,
            last.hidden,
            brake[-1] if brake else None,
            _blinks([(at, item.left_blinker) for at, item in recent]),
            _blinks([(at, item.right_blinker) for at, item in recent]),
            *(_agreed(known.slow.get(name, ())) if recent else None for name in SLOW),
        )

    def keep(self, track_ids: Iterable[int]) -> None:
        """Forget all tracks but these."""
        wanted = set(track_ids)
        self._known = {name: item for name, item in self._known.items() if name in wanted}


def _kind(known: _AttributeHistory) -> tuple[ObjectKind | None, float, Floats | None]:
    if not known.votes.any():
        return None, 0.0, None
    shares = softmax(known.votes)
    best = int(shares.argmax())
    kind, sure = ObjectKind(KINDS[best]), float(shares[best])
    enough = known.said[kind] >= LOOKS and sure >= (PASSABLE_VOTED if kind in PASSABLE_KINDS else VOTED)
    if kind in PASSABLE_KINDS and any(look.kind not in (None, kind) for _, look in known.looks):
        enough = False  # a bag that just looked like a rock is not driven over
    return kind if enough else None, sure, np.append(shares, 0.0)


def _vote(known: _AttributeHistory, look: Attributes) -> None:
    """A look at a hidden object says nothing about its kind."""
    shares = look.kind_shares
    if shares is None or int(shares.argmax()) == _NOTHING:
        return
    logs = np.log(np.maximum(shares[:_NOTHING], 1e-6))
    known.votes += LOOK_WEIGHT * np.maximum(logs - logs.max(), -LOOK_CAP)
    known.votes = np.maximum(known.votes - known.votes.max(), -VOTE_CAP)
    if look.kind is not None:
        known.said[look.kind] += 1


def _blinks(looks: list[tuple[float, bool | None]]) -> bool | None:
    """Return True if a lamp that is sometimes dark is blinking."""
    told = [(at, lit) for at, lit in looks if lit is not None]
    if any(lit for _, lit in told):
        return True
    if len(told) >= BLINK_LOOKS and told[-1][0] - told[0][0] >= BLINK_LEAST_S:
        return False
    return None


def _agreed(answers: Iterable[Any]) -> Any:
    counted = Counter(answers).most_common(1)
    return counted[0][0] if counted and counted[0][1] >= AGREE else None
