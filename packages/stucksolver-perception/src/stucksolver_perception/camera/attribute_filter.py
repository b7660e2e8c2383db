"""Combines the attributes of each tracked object over several images: kinds by vote, blinkers over time.

A *look* is one reading of an object in one image.
"""

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
    """The attributes of one object; None for attributes that are not certain enough."""

    kind: ObjectKind | None = None
    kind_confidence: float = 0.0
    """Confidence of the most probable kind, reported or not; 0 without a look."""
    kind_shares: Floats | None = None
    """(len(KINDS),) probabilities for the vote; None without a look."""
    hidden: bool | None = None
    """True if the box shows another object, or none."""
    brake_lights: bool | None = None
    left_blinker: bool | None = None
    """True if the lamp is lit (in a single image), or if it blinks (in a filter)."""
    right_blinker: bool | None = None
    emergency_lights: bool | None = None
    door_open: bool | None = None
    gesture: Gesture | None = None
    """Gesture of a flagger; None for all other kinds."""

    @property
    def hazard_lights(self) -> bool | None:
        """True if both blinkers blink; False if one of them is off."""
        both = (self.left_blinker, self.right_blinker)
        return False if False in both else (True if all(both) else None)


MIN_CONFIRMATIONS = 2
"""Number of looks with a certain kind after which the kind is reported. Ours."""
MIN_SHARE, PASSABLE_MIN_SHARE = 0.9, 0.99
"""Required share of the vote for a kind, and for a kind that may be driven over. Ours."""
LOOK_WEIGHT = 0.5
"""Weight of a look in the vote. Looks at the same object are correlated, so each counts half. Ours."""
LOOK_CAP, VOTE_CAP = 4.0, 9.0
"""Maximum distance of a kind to the most probable one in one look, and in the vote (nats). The limits allow a vote to
change. Ours."""
BLINK_S = 1.5
"""Time for which looks are stored (s): two periods of the slowest common blinkers, minus the time that they are lit."""
BLINK_MIN_LOOKS, BLINK_MIN_S = 3, 0.9
"""Minimum number and minimum duration (s) of looks that all show a dark lamp for a blinker that is off. Ours."""
BRAKE_S = 0.6
"""Time for which a look at the brake lamps is valid (s). Ours."""
MIN_AGREEING = 2
"""Required number of equal answers in the last three looks for emergency lights, doors and gestures. Ours."""
SLOW_FIELDS = ("emergency_lights", "door_open", "gesture")
"""Attributes that change slowly, in the order of the last fields of `Attributes`."""
_NOTHING = KINDS.index(NOTHING)


@dataclass
class _AttributeHistory:
    votes: Floats = field(default_factory=lambda: np.zeros(_NOTHING))
    confirmations: Counter[ObjectKind] = field(default_factory=Counter)
    looks: deque[tuple[float, Attributes]] = field(default_factory=deque)
    """The looks of the last `BLINK_S`, oldest first."""
    slow: dict[str, deque[Any]] = field(default_factory=dict)
    """The last three answers for the slow attributes, by name."""


class AttributeFilter:
    """The combined attributes of all tracks."""

    def __init__(self) -> None:
        self._histories: dict[int, _AttributeHistory] = {}

    def add(self, track_id: int, look: Attributes, time_s: float) -> None:
        """Add a look at a track. Looks must come in order of time."""
        if look.kind_shares is None:
            return
        history = self._histories.setdefault(track_id, _AttributeHistory())
        _vote(history, look)
        if not history.looks or time_s - history.looks[-1][0] > BLINK_S:
            history.slow.clear()
        history.looks.append((time_s, look))
        for name in SLOW_FIELDS:
            answer = getattr(look, name)
            if answer is not None:
                history.slow.setdefault(name, deque(maxlen=3)).append(answer)

    def get(self, track_id: int, time_s: float) -> Attributes | None:
        """Return the attributes of a track at a time; None without any look at it."""
        history = self._histories.get(track_id)
        if history is None:
            return None
        while history.looks and time_s - history.looks[0][0] > BLINK_S:
            history.looks.popleft()
        kind, confidence, shares = _kind(history)
        recent = list(history.looks)
        last = recent[-1][1] if recent else Attributes()
        brake = [
            look.brake_lights for look_s, look in recent if time_s - look_s <= BRAKE_S and look.brake_lights is not None
        ]
        return Attributes(
            kind,
            confidence,
            shares,
            last.hidden,
            brake[-1] if brake else None,
            _blinks([(look_s, look.left_blinker) for look_s, look in recent]),
            _blinks([(look_s, look.right_blinker) for look_s, look in recent]),
            *(_agreed(history.slow.get(name, ())) if recent else None for name in SLOW_FIELDS),
        )

    def keep(self, track_ids: Iterable[int]) -> None:
        """Drop all tracks but these."""
        kept_ids = set(track_ids)
        self._histories = {name: item for name, item in self._histories.items() if name in kept_ids}


def _kind(history: _AttributeHistory) -> tuple[ObjectKind | None, float, Floats | None]:
    if not history.votes.any():
        return None, 0.0, None
    shares = softmax(history.votes)
    best = int(shares.argmax())
    kind, confidence = ObjectKind(KINDS[best]), float(shares[best])
    is_certain = history.confirmations[kind] >= MIN_CONFIRMATIONS and confidence >= (
        PASSABLE_MIN_SHARE if kind in PASSABLE_KINDS else MIN_SHARE
    )
    if kind in PASSABLE_KINDS and any(look.kind not in (None, kind) for _, look in history.looks):
        is_certain = False  # no object is driven over that was another kind in a recent look
    return kind if is_certain else None, confidence, np.append(shares, 0.0)


def _vote(history: _AttributeHistory, look: Attributes) -> None:
    """Add a look to the vote. A look at a hidden object does not count."""
    shares = look.kind_shares
    if shares is None or int(shares.argmax()) == _NOTHING:
        return
    logs = np.log(np.maximum(shares[:_NOTHING], 1e-6))
    history.votes += LOOK_WEIGHT * np.maximum(logs - logs.max(), -LOOK_CAP)
    history.votes = np.maximum(history.votes - history.votes.max(), -VOTE_CAP)
    if look.kind is not None:
        history.confirmations[look.kind] += 1


def _blinks(looks: list[tuple[float, bool | None]]) -> bool | None:
    """Return True if a lamp blinks, False if it is off, and None if the looks do not suffice."""
    usable = [(time_s, lit) for time_s, lit in looks if lit is not None]
    if any(lit for _, lit in usable):
        return True
    if len(usable) >= BLINK_MIN_LOOKS and usable[-1][0] - usable[0][0] >= BLINK_MIN_S:
        return False
    return None


def _agreed(answers: Iterable[Any]) -> Any:
    counted = Counter(answers).most_common(1)
    return counted[0][0] if counted and counted[0][1] >= MIN_AGREEING else None
