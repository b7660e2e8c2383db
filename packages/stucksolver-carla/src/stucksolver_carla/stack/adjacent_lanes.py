"""The lanes beside a waypoint, from the route outward, each with the line to cross into it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import carla

from stucksolver.scene import LaneDirection, LaneKind, LineKind
from stucksolver_carla.stack.carla_frames import to_local

MAX_LANES = 5
"""To each side; lanes further out do not matter to a recovery."""


@dataclass(frozen=True)
class AdjacentLane:
    """One lane at one station. `place` counts from the route's lane (0), positive to the left."""

    place: int
    kind: LaneKind
    direction: LaneDirection
    offset_m: float
    width_m: float
    line: LineKind


_KINDS = {
    carla.LaneType.Driving: LaneKind.DRIVING,
    carla.LaneType.Bidirectional: LaneKind.DRIVING,
    carla.LaneType.Biking: LaneKind.BIKING,
    carla.LaneType.Parking: LaneKind.PARKING,
    carla.LaneType.Shoulder: LaneKind.SHOULDER,
    carla.LaneType.Sidewalk: LaneKind.SIDEWALK,
}
_BROKEN = {carla.LaneMarkingType.Broken, carla.LaneMarkingType.BrokenBroken, carla.LaneMarkingType.BottsDots}
_NONE = {carla.LaneMarkingType.NONE, carla.LaneMarkingType.Other}
_KERB = {carla.LaneMarkingType.Curb, carla.LaneMarkingType.Grass}
_NEAR_SIDE_BROKEN = carla.LaneMarkingType.BrokenSolid


def neighbours(
    waypoint: carla.Waypoint, x: float, y: float, heading: float, *, alone: bool
) -> tuple[AdjacentLane, ...]:
    """Return the route's lane and those beside it; only the route's if `alone` (lanes overlap inside junctions)."""
    own = AdjacentLane(0, LaneKind.DRIVING, LaneDirection.SAME, 0.0, float(waypoint.lane_width), LineKind.NONE)
    if alone:
        return (own,)
    return (own, *_walk(waypoint, x, y, heading, +1), *_walk(waypoint, x, y, heading, -1))


def _walk(start: Any, x: float, y: float, heading: float, side: int) -> list[AdjacentLane]:
    found: list[AdjacentLane] = []
    here, same = start, True
    while len(found) < MAX_LANES:
        # Seen from a lane in the opposite direction, further to our left is further to its right.
        to_left = (side > 0) == same
        beside = here.get_left_lane() if to_left else here.get_right_lane()
        if beside is None:
            break
        marking = here.left_lane_marking if to_left else here.right_lane_marking
        turn = math.remainder(-math.radians(beside.transform.rotation.yaw) - heading, math.tau)
        same = abs(turn) < math.pi / 2
        px, py = to_local(beside.transform.location)
        offset = (py - y) * math.cos(heading) - (px - x) * math.sin(heading)
        kind = _KINDS.get(beside.lane_type)
        if kind is not None:
            direction = LaneDirection.SAME if same else LaneDirection.OPPOSITE
            place = side * (len(found) + 1)
            found.append(
                AdjacentLane(place, kind, direction, offset, float(beside.lane_width), line_kind(marking, kind))
            )
        elif found and found[-1].kind is not LaneKind.DRIVING:
            break
        here = beside
        if kind is None and abs(offset) > 30.0:
            break
    return found


def line_kind(marking: Any, into: LaneKind) -> LineKind:
    """Return a marking as it applies to a vehicle on the route's side of it."""
    if into is LaneKind.SIDEWALK or (marking is not None and marking.type in _KERB):
        return LineKind.KERB
    if marking is None or marking.type in _NONE:
        return LineKind.NONE
    if marking.type in _BROKEN or marking.type == _NEAR_SIDE_BROKEN:
        return LineKind.BROKEN
    return LineKind.SOLID
