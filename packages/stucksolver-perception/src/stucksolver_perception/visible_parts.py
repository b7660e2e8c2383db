"""Ground truth of what the camera can see of recorded objects: lamps, doors and a flagger's gesture.

No network can read a lamp that is lit on the far side of a vehicle. Staged scenes measure what is visible; in drives it
follows from the instance mask: the points where lamps or open doors are must show the object's own pixels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stucksolver.scene.objects import MOTOR_VEHICLES, TWO_WHEELED, Gesture, ObjectKind
from stucksolver_perception.measurements import Floats
from stucksolver_perception.recording import GESTURES, KINDS, PARTS, Recorded
from stucksolver_perception.rig import CameraRig

BRAKE = 8
LEFT = 32
RIGHT = 16
SPECIAL = 512 | 1024
"""Bits of `carla.VehicleLightState`."""
SPECIAL_KINDS = frozenset({ObjectKind.EMERGENCY, ObjectKind.SCHOOL_BUS})
"""Kinds with emergency or warning lights."""
LEAST_PX, LEAST_PERSON_PX = 20.0, 24.0
"""Lamps and doors can be seen from this size of the vehicle's rectangle on, gestures from this height of the person."""
SHOWN = 0.5
"""Fraction of a lamp's points that must show the vehicle."""
SHOWN_DOOR = 0.35
"""The same for an open door, whose window is taken for what is behind it."""
SHOWN_ROOF = 0.25
SHOWN_PERSON = 0.2
"""Fraction of a person's rectangle that must be its own pixels; people do not fill theirs."""
INNER = 0.97
"""A vehicle's body blocks the view through this fraction of its box, which is rounded at the corners."""
DOOR_M = (0.25, 0.5, 0.75)
"""How far the points of an open door lie outside the vehicle's side (m)."""
SIDE_DOORS = ((0.36, 1.0), (0.36, -1.0), (-0.08, 1.0), (-0.08, -1.0))
"""Hinges of the doors of `carla.VehicleDoor` in order: half lengths ahead of the center, and the side (1: left)."""
HINGE_M = (-0.1, -0.25)
"""Where the points of an open door are, ahead of its hinge (m)."""
PADDLES = {
    Gesture.STOP: (0.42, -0.11, 0.31),
    Gesture.SLOW: (0.36, -0.11, 0.11),
    Gesture.GO: (0.06, -0.47, 0.31),
}
"""Where carlette's flaggers hold their paddle: ahead, left and above the middle of the body, in heights of the body."""
PADDLE_UP_M, PADDLE_HALF_M = 0.72, 0.15
"""How far the middle of the sign is above the hand, and of its points from that middle (m)."""
_EVERY_ID = 65536


@dataclass(frozen=True)
class VisibleAttributes:
    """What can be seen of one object. A name that is missing is unknown, or the object cannot have it."""

    lamps: dict[str, bool | None]
    """True if on or open; None if it cannot be seen."""
    so: dict[str, bool]
    """The same whether it can be seen or not."""
    gesture: Gesture | None
    """None if the paddle, or where it could be, cannot be seen, or the object is no flagger."""
    shows: Gesture | None = None
    """The flagger's gesture whether it can be seen or not; None if the object is no flagger, or it is unknown."""

    @property
    def is_flagger(self) -> bool:
        """Whether the object is a flagger with a known gesture."""
        return self.shows is not None


class VisibleParts:
    """Reads the visible parts of the objects of one tick with a mask.

    Args:
        tick: The recorded tick.
        rig: The camera.
        boxes: (n, 7) boxes of its objects in the frame of the ego's body: center, length, width, height (m), yaw (rad).
    """

    def __init__(self, tick: Recorded, rig: CameraRig, boxes: Floats) -> None:
        if tick.instances is None:
            raise ValueError("this tick has no instance mask")
        self._tick, self._rig, self._boxes, self._mask = tick, rig, boxes, tick.instances
        self._lens = rig.mount.to_vehicle()[:3, 3]
        ids = (tick.truth.actor_id % _EVERY_ID).tolist()
        away = np.hypot(*(boxes[:, :2] - self._lens[:2]).T).tolist() if len(boxes) else []
        self._away = dict(zip(ids, away, strict=True))

    def get(self, i: int, rectangle: Floats) -> VisibleAttributes:
        """Return what can be seen of the object with index `i`.

        Args:
            i: Index in the truth.
            rectangle: Where its box is in the image: left, top, right, bottom (px).
        """
        truth = self._tick.truth
        kind = KINDS[int(truth.kind[i])]
        longer = float(np.max(rectangle[2:] - rectangle[:2]))
        if kind is ObjectKind.FLAGGER:
            told = int(truth.gesture[i])
            shows = GESTURES[told] if told >= 0 else None
            return VisibleAttributes(
                {}, {}, None if shows is None else self._gesture(i, shows, rectangle, longer), shows
            )
        if kind not in MOTOR_VEHICLES:
            return VisibleAttributes({}, {}, None)
        measured = int(truth.shown[i])
        so = self._so(i, kind)
        lamps = self._lamps(i, kind, so, longer >= LEAST_PX)
        if measured >= 0:
            # Both must hold: pixels also change in the light of other vehicles' lamps.
            for bit, name in enumerate(PARTS):
                if lamps.get(name) is not None and not measured & 1 << bit:
                    lamps[name] = None
            if kind not in SPECIAL_KINDS:
                lamps["emergency_lights"] = False
        return VisibleAttributes(lamps, so, None)

    def _so(self, i: int, kind: ObjectKind) -> dict[str, bool]:
        flags, doors = int(self._tick.truth.lamps[i]), int(self._tick.truth.doors[i])
        found: dict[str, bool] = {}
        if flags >= 0:
            special = kind in SPECIAL_KINDS and bool(flags & SPECIAL)
            lit = (bool(flags & BRAKE), bool(flags & LEFT), bool(flags & RIGHT), special)
            found |= dict(zip(PARTS, lit, strict=False))
        return found if doors < 0 else found | {PARTS[-1]: bool(doors)}

    def _lamps(self, i: int, kind: ObjectKind, so: dict[str, bool], large: bool) -> dict[str, bool | None]:
        found: dict[str, bool | None] = {}
        if "brake_lights" in so:
            lamps = _lamp_points(kind)
            shows = {name: large and self._share(i, points) >= SHOWN for name, points in lamps.items()}
            rear = shows["rear left"] or shows["rear right"]
            found["brake_lights"] = so["brake_lights"] if rear else None
            for side in ("left", "right"):
                any_of = any(shows[f"{place} {side}"] for place in ("rear", "front", "side"))
                found[f"{side}_blinker"] = so[f"{side}_blinker"] if any_of else None
            roof = kind not in SPECIAL_KINDS or (large and self._share(i, _ROOF, behind=True) >= SHOWN_ROOF)
            found["emergency_lights"] = so["emergency_lights"] if roof else None
        if "door_open" in so:
            found |= self._doors(i, int(self._tick.truth.doors[i]), large)
        return found

    def _doors(self, i: int, doors: int, large: bool) -> dict[str, bool | None]:
        """Open if an open door is seen, shut if a side is and no door is open. Missing if the open one is hidden."""
        if not large:
            return {"door_open": None}
        is_open = [bool(doors & 1 << number) for number in range(len(SIDE_DOORS))]
        if any(so and self._door_share(i, n, own=True) >= SHOWN_DOOR for n, so in enumerate(is_open)):
            return {"door_open": True}
        if any(is_open):
            return {}
        clear = any(self._door_share(i, n, own=False) >= SHOWN for n in range(len(SIDE_DOORS)))
        return {"door_open": False if clear else None}

    def _door_share(self, i: int, number: int, *, own: bool) -> float:
        """Fraction of the points of a door, open or not, that the camera sees; if `own`, with the vehicle's pixels."""
        hinge, side = SIDE_DOORS[number]
        length, width, height = self._boxes[i, 3:6].tolist()
        points = np.array(
            [
                (hinge * length / 2.0 + ahead, side * (width / 2.0 + out), up * height / 2.0)
                for ahead in HINGE_M
                for out in DOOR_M
                for up in (-0.35, -0.1, 0.1)
            ]
        )
        return self._fraction(i, points, own=own)

    def _share(self, i: int, points: Floats, *, behind: bool = False) -> float:
        """The same for points in half sizes of the box; `behind` if its own body does not block the view to them."""
        return self._fraction(i, points * self._boxes[i, 3:6] / 2.0, behind=behind)

    def _fraction(self, i: int, points: Floats, *, own: bool = True, behind: bool = False) -> float:
        box = self._boxes[i]
        cos, sin = float(np.cos(box[6])), float(np.sin(box[6]))
        turned = np.stack([points[:, 0] * cos - points[:, 1] * sin, points[:, 0] * sin + points[:, 1] * cos], axis=1)
        column, row, ahead = self._rig.project(np.column_stack([turned + box[:2], points[:, 2] + box[2]]))
        wide, high = self._rig.width_px, self._rig.height_px
        inside = (ahead > 0.1) & (column >= 0) & (column < wide) & (row >= 0) & (row < high)
        seen = np.zeros(len(points), bool)
        at = self._mask[row[inside].astype(int), column[inside].astype(int)]
        actor = int(self._tick.truth.actor_id[i]) % _EVERY_ID
        if own:
            seen[inside] = at == actor
        else:
            limit = self._away[actor]
            seen[inside] = [item == actor or self._away.get(item, np.inf) > limit for item in at.tolist()]
        if not behind:
            lens = np.array([[cos, sin], [-sin, cos]]) @ (self._lens[:2] - box[:2])
            seen &= ~_crosses(lens, points[:, :2], INNER * box[3:5] / 2.0)
        return float(seen.mean())

    def _gesture(self, i: int, gesture: Gesture, rectangle: Floats, longer: float) -> Gesture | None:
        left, top = (int(item) for item in rectangle[:2])
        right, bottom = (int(np.ceil(item)) for item in rectangle[2:])
        part = self._mask[top:bottom, left:right]
        own = np.count_nonzero(part == int(self._tick.truth.actor_id[i]) % _EVERY_ID) / max(part.size, 1)
        if longer < LEAST_PERSON_PX or own < SHOWN_PERSON:
            return None
        if gesture in PADDLES:
            return gesture if self._paddle_share(i, PADDLES[gesture], own=True) >= SHOWN else None
        # Without a paddle, nothing may hide the places where it would be.
        clear = all(self._paddle_share(i, place, own=False) >= SHOWN for place in PADDLES.values())
        return gesture if clear else None

    def _paddle_share(self, i: int, place: tuple[float, float, float], *, own: bool) -> float:
        """Fraction of a paddle's points that the camera sees; if `own`, with the flagger's pixels."""
        height, off = float(self._boxes[i, 5]), PADDLE_HALF_M
        middle = height * np.array(place) + (0.0, 0.0, PADDLE_UP_M)
        points = middle + np.array([(0.0, a, b) for a in (-off, 0.0, off) for b in (-off, 0.0, off)])
        return self._fraction(i, points, own=own, behind=True)


def _lamp_points(kind: ObjectKind) -> dict[str, Floats]:
    """Points near the lamps in half sizes of the box, by place; low on tall vehicles, in the middle of narrow ones."""
    out = (0.1, 0.3, 0.5) if kind in TWO_WHEELED else (0.6, 0.75, 0.9)
    up = (-0.6, -0.5, -0.4) if kind in _TALL else (-0.3, -0.1, 0.1)
    found = {}
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for end, x in (("rear", -1.01), ("front", 1.01)):
            found[f"{end} {side}"] = np.array([(x, sign * y, z) for y in out for z in up])
        found[f"side {side}"] = np.array([(x, sign * 1.01, z) for x in (-0.97, -0.92, 0.92, 0.97) for z in up])
    return found


_TALL = frozenset({ObjectKind.TRUCK, ObjectKind.BUS, ObjectKind.SCHOOL_BUS})
_ROOF = np.array([(x, y, z) for x in (-0.98, -0.2, 0.1, 0.4, 0.7) for y in (-0.3, 0.3) for z in (0.8, 0.93)])


def _crosses(start: Floats, ends: Floats, half: Floats) -> NDArray[np.bool_]:
    """Whether segments from `start` (2,) to `ends` (n, 2) cross the rectangle of these half sizes around the origin."""
    way = ends - start
    safe = np.where(np.abs(way) < 1e-9, 1e-9, way)
    first, last = (-half - start) / safe, (half - start) / safe
    enters, leaves = np.minimum(first, last).max(1), np.maximum(first, last).min(1)
    return np.asarray((enters < leaves) & (leaves > 0.0) & (enters < 1.0))
