"""Computes which lamps, doors and gestures of recorded objects are visible to the camera, as ground truth.

No network can read a lamp on the far side of a vehicle. Staged scenes measure which parts are visible. In drives the
instance mask gives it: at the positions of lamps or open doors, the mask must have pixels of the object.
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
"""Bit of the brake lamps in `carla.VehicleLightState`."""
LEFT = 32
"""Bit of the left blinker."""
RIGHT = 16
"""Bit of the right blinker."""
SPECIAL = 512 | 1024
"""Bits of the emergency lights (`Special1`, `Special2`)."""
SPECIAL_KINDS = frozenset({ObjectKind.EMERGENCY, ObjectKind.SCHOOL_BUS})
"""Kinds with emergency or warning lights."""
MIN_VEHICLE_PX, MIN_PERSON_PX = 20.0, 24.0
"""Minimum size of a vehicle's rectangle with visible lamps and doors, and minimum size of a person's rectangle with a
visible gesture (px). Ours."""
LAMP_SHARE = 0.5
"""Minimum share of a lamp's points with the vehicle's pixels. Ours."""
DOOR_SHARE = 0.35
"""Minimum share of an open door's points with the vehicle's pixels. The mask shows through the window. Ours."""
ROOF_SHARE = 0.25
"""Minimum share of the roof's points with the vehicle's pixels, for emergency lights. Ours."""
PERSON_SHARE = 0.2
"""Minimum share of a person's rectangle with the person's pixels; a person never fills it. Ours."""
BODY_SHARE = 0.97
"""Part of a vehicle's box, which is rounded at the corners, that blocks the view. Ours."""
DOOR_M = (0.25, 0.5, 0.75)
"""Distances of an open door's points from the vehicle's side (m). Ours."""
SIDE_DOORS = ((0.36, 1.0), (0.36, -1.0), (-0.08, 1.0), (-0.08, -1.0))
"""Hinges of the doors in the order of `carla.VehicleDoor`: half lengths ahead of the center, and the side (1: left)."""
HINGE_M = (-0.1, -0.25)
"""Positions of an open door's points ahead of its hinge (m). Ours."""
PADDLES = {
    Gesture.STOP: (0.42, -0.11, 0.31),
    Gesture.SLOW: (0.36, -0.11, 0.11),
    Gesture.GO: (0.06, -0.47, 0.31),
}
"""Position of the hand with the paddle of carlette's flaggers: ahead, left and above the body's center, in heights of
the body."""
PADDLE_UP_M, PADDLE_HALF_M = 0.72, 0.15
"""Height of the sign's center above the hand, and distance of the sign's points from that center (m)."""
_ID_MODULUS = 65536
"""The mask contains actor ids modulo this."""


@dataclass(frozen=True)
class VisibleAttributes:
    """The visible attributes of one object. A missing name is unknown, or the object cannot have it."""

    lamps: dict[str, bool | None]
    """True for a lit lamp or an open door; None if it is not visible."""
    truth_flags: dict[str, bool]
    """True for a lit lamp or an open door, visible or not."""
    gesture: Gesture | None
    """The flagger's gesture; None if the paddle, or where it could be, is not visible, or for another object."""
    shows: Gesture | None = None
    """The flagger's gesture, visible or not; None if it is unknown, or for another object."""

    @property
    def is_flagger(self) -> bool:
        """True if the object is a flagger with a known gesture."""
        return self.shows is not None


class VisibleParts:
    """The visible parts of the objects of one tick with a mask.

    Args:
        tick: The recorded tick.
        rig: The camera.
        boxes: (n, 7): boxes of its objects in the frame of the ego's body: center, length, width, height (m), yaw
            (rad).

    Raises:
        ValueError: The tick has no mask.
    """

    def __init__(self, tick: Recorded, rig: CameraRig, boxes: Floats) -> None:
        if tick.instances is None:
            raise ValueError("this tick has no instance mask")
        self._tick, self._rig, self._boxes, self._mask = tick, rig, boxes, tick.instances
        self._lens = rig.mount.to_vehicle()[:3, 3]
        ids = (tick.truth.actor_id % _ID_MODULUS).tolist()
        distances = np.hypot(*(boxes[:, :2] - self._lens[:2]).T).tolist() if len(boxes) else []
        self._distance_by_id = dict(zip(ids, distances, strict=True))

    def get(self, i: int, rectangle: Floats) -> VisibleAttributes:
        """Return the visible attributes of the object with index `i`.

        Args:
            i: Index in the truth.
            rectangle: Its box in the image: left, top, right, bottom (px).
        """
        truth = self._tick.truth
        kind = KINDS[int(truth.kind[i])]
        longer = float(np.max(rectangle[2:] - rectangle[:2]))
        if kind is ObjectKind.FLAGGER:
            index = int(truth.gesture[i])
            shows = GESTURES[index] if index >= 0 else None
            return VisibleAttributes(
                {}, {}, None if shows is None else self._gesture(i, shows, rectangle, longer), shows
            )
        if kind not in MOTOR_VEHICLES:
            return VisibleAttributes({}, {}, None)
        measured = int(truth.shown[i])
        truth_flags = self._true_flags(i, kind)
        lamps = self._lamps(i, kind, truth_flags, longer >= MIN_VEHICLE_PX)
        if measured >= 0:
            # A lamp must be visible in both, because pixels also change in the light of other vehicles' lamps.
            for bit, name in enumerate(PARTS):
                if lamps.get(name) is not None and not measured & 1 << bit:
                    lamps[name] = None
            if kind not in SPECIAL_KINDS:
                lamps["emergency_lights"] = False
        return VisibleAttributes(lamps, truth_flags, None)

    def _true_flags(self, i: int, kind: ObjectKind) -> dict[str, bool]:
        flags, doors = int(self._tick.truth.lamps[i]), int(self._tick.truth.doors[i])
        attributes: dict[str, bool] = {}
        if flags >= 0:
            special = kind in SPECIAL_KINDS and bool(flags & SPECIAL)
            lit = (bool(flags & BRAKE), bool(flags & LEFT), bool(flags & RIGHT), special)
            attributes |= dict(zip(PARTS, lit, strict=False))
        return attributes if doors < 0 else attributes | {PARTS[-1]: bool(doors)}

    def _lamps(self, i: int, kind: ObjectKind, truth_flags: dict[str, bool], large: bool) -> dict[str, bool | None]:
        attributes: dict[str, bool | None] = {}
        if "brake_lights" in truth_flags:
            lamps = _lamp_points(kind)
            shows = {name: large and self._visible_share(i, points) >= LAMP_SHARE for name, points in lamps.items()}
            rear = shows["rear left"] or shows["rear right"]
            attributes["brake_lights"] = truth_flags["brake_lights"] if rear else None
            for side in ("left", "right"):
                is_visible = any(shows[f"{end} {side}"] for end in ("rear", "front", "side"))
                attributes[f"{side}_blinker"] = truth_flags[f"{side}_blinker"] if is_visible else None
            roof = kind not in SPECIAL_KINDS or (large and self._visible_share(i, _ROOF, behind=True) >= ROOF_SHARE)
            attributes["emergency_lights"] = truth_flags["emergency_lights"] if roof else None
        if "door_open" in truth_flags:
            attributes |= self._doors(i, int(self._tick.truth.doors[i]), large)
        return attributes

    def _doors(self, i: int, doors: int, large: bool) -> dict[str, bool | None]:
        """Return open if an open door is visible, and shut if no door is open and one would be visible.

        The result has no entry if the open door is hidden.
        """
        if not large:
            return {"door_open": None}
        is_open = [bool(doors & 1 << number) for number in range(len(SIDE_DOORS))]
        if any(door and self._door_share(i, n, own=True) >= DOOR_SHARE for n, door in enumerate(is_open)):
            return {"door_open": True}
        if any(is_open):
            return {}
        is_clear = any(self._door_share(i, n, own=False) >= LAMP_SHARE for n in range(len(SIDE_DOORS)))
        return {"door_open": False if is_clear else None}

    def _door_share(self, i: int, number: int, *, own: bool) -> float:
        """Return the visible share of the points of a door, open or not; if `own`, with the vehicle's pixels."""
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
        return self._visible_share_at(i, points, own=own)

    def _visible_share(self, i: int, points: Floats, *, behind: bool = False) -> float:
        """Return the visible share of points in half sizes of the box; see `_visible_share_at`."""
        return self._visible_share_at(i, points * self._boxes[i, 3:6] / 2.0, behind=behind)

    def _visible_share_at(self, i: int, points: Floats, *, own: bool = True, behind: bool = False) -> float:
        """Return the visible share of points (n, 3) relative to the box's center, along its axes (m).

        If `own`, a visible point has the object's pixel in the mask. Otherwise it may also have that of an object
        farther away. If `behind`, the object's own body does not block the view.
        """
        box = self._boxes[i]
        cos, sin = float(np.cos(box[6])), float(np.sin(box[6]))
        turned = np.stack([points[:, 0] * cos - points[:, 1] * sin, points[:, 0] * sin + points[:, 1] * cos], axis=1)
        column, row, ahead = self._rig.project(np.column_stack([turned + box[:2], points[:, 2] + box[2]]))
        width, height = self._rig.width_px, self._rig.height_px
        inside = (ahead > 0.1) & (column >= 0) & (column < width) & (row >= 0) & (row < height)
        visible = np.zeros(len(points), bool)
        pixels = self._mask[row[inside].astype(int), column[inside].astype(int)]
        actor = int(self._tick.truth.actor_id[i]) % _ID_MODULUS
        if own:
            visible[inside] = pixels == actor
        else:
            limit = self._distance_by_id[actor]
            visible[inside] = [
                item == actor or self._distance_by_id.get(item, np.inf) > limit for item in pixels.tolist()
            ]
        if not behind:
            lens = np.array([[cos, sin], [-sin, cos]]) @ (self._lens[:2] - box[:2])
            visible &= ~_crosses(lens, points[:, :2], BODY_SHARE * box[3:5] / 2.0)
        return float(visible.mean())

    def _gesture(self, i: int, gesture: Gesture, rectangle: Floats, longer: float) -> Gesture | None:
        left, top = (int(item) for item in rectangle[:2])
        right, bottom = (int(np.ceil(item)) for item in rectangle[2:])
        part = self._mask[top:bottom, left:right]
        own_share = np.count_nonzero(part == int(self._tick.truth.actor_id[i]) % _ID_MODULUS) / max(part.size, 1)
        if longer < MIN_PERSON_PX or own_share < PERSON_SHARE:
            return None
        if gesture in PADDLES:
            return gesture if self._paddle_share(i, PADDLES[gesture], own=True) >= LAMP_SHARE else None
        # Without a paddle, all positions where it could be must be visible.
        is_clear = all(self._paddle_share(i, offset, own=False) >= LAMP_SHARE for offset in PADDLES.values())
        return gesture if is_clear else None

    def _paddle_share(self, i: int, offset: tuple[float, float, float], *, own: bool) -> float:
        """Return the visible share of a paddle's points; if `own`, with the flagger's pixels."""
        height, half = float(self._boxes[i, 5]), PADDLE_HALF_M
        center = height * np.array(offset) + (0.0, 0.0, PADDLE_UP_M)
        points = center + np.array([(0.0, a, b) for a in (-half, 0.0, half) for b in (-half, 0.0, half)])
        return self._visible_share_at(i, points, own=own, behind=True)


def _lamp_points(kind: ObjectKind) -> dict[str, Floats]:
    """Return points near the lamps in half sizes of the box, by position.

    They are low on tall vehicles, and in the middle of two-wheelers.
    """
    lateral = (0.1, 0.3, 0.5) if kind in TWO_WHEELED else (0.6, 0.75, 0.9)
    up = (-0.6, -0.5, -0.4) if kind in _TALL else (-0.3, -0.1, 0.1)
    points = {}
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for end, x in (("rear", -1.01), ("front", 1.01)):
            points[f"{end} {side}"] = np.array([(x, sign * y, z) for y in lateral for z in up])
        points[f"side {side}"] = np.array([(x, sign * 1.01, z) for x in (-0.97, -0.92, 0.92, 0.97) for z in up])
    return points


_TALL = frozenset({ObjectKind.TRUCK, ObjectKind.BUS, ObjectKind.SCHOOL_BUS})
_ROOF = np.array([(x, y, z) for x in (-0.98, -0.2, 0.1, 0.4, 0.7) for y in (-0.3, 0.3) for z in (0.8, 0.93)])


def _crosses(start: Floats, ends: Floats, half: Floats) -> NDArray[np.bool_]:
    """Return True for segments from `start` (2,) to `ends` (n, 2) that cross the rectangle around the origin."""
    segments = ends - start
    safe = np.where(np.abs(segments) < 1e-9, 1e-9, segments)
    first, last = (-half - start) / safe, (half - start) / safe
    enters, leaves = np.minimum(first, last).max(1), np.maximum(first, last).min(1)
    return np.asarray((enters < leaves) & (leaves > 0.0) & (enters < 1.0))
