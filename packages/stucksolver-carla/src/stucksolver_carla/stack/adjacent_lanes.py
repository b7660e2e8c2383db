"""Finds the lanes next to a waypoint, from the route outward, each with the line in between."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import carla

from stucksolver.scene import LaneDirection, LaneKind, LineKind
from stucksolver_carla.stack.carla_frames import to_local

MAX_LANES = 5
"""Maximum number of lanes on each side. No recovery uses lanes farther out. Ours."""


@dataclass(frozen=True)
class AdjacentLane:
    """One lane at one station. `place` counts from the route's lane (0), positive to the left; `offset_m` too."""

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
_CURB = {carla.LaneMarkingType.Curb, carla.LaneMarkingType.Grass}
_NEAR_SIDE_BROKEN = carla.LaneMarkingType.BrokenSolid


def adjacent_lanes(
    waypoint: carla.Waypoint, x: float, y: float, heading: float, *, only_own: bool
) -> tuple[AdjacentLane, ...]:
    """Return the route's lane and its adjacent lanes; only the route's with `only_own`.

    `only_own` is for junctions, where lanes overlap. x, y (m) and heading (rad) are in the local frame.
    """
    own = AdjacentLane(0, LaneKind.DRIVING, LaneDirection.SAME, 0.0, float(waypoint.lane_width), LineKind.NONE)
    if only_own:
        return (own,)
    return (own, *_lanes_on_side(waypoint, x, y, heading, +1), *_lanes_on_side(waypoint, x, y, heading, -1))


def _lanes_on_side(start: Any, x: float, y: float, heading: float, side: int) -> list[AdjacentLane]:
    lanes: list[AdjacentLane] = []
    here, is_same_direction = start, True
    while len(lanes) < MAX_LANES:
        # In a lane of the opposite direction, the route's left is that lane's right.
        is_left = (side > 0) == is_same_direction
        next_lane = here.get_left_lane() if is_left else here.get_right_lane()
        if next_lane is None:
            break
        marking = here.left_lane_marking if is_left else here.right_lane_marking
        turn = math.remainder(-math.radians(next_lane.transform.rotation.yaw) - heading, math.tau)
        is_same_direction = abs(turn) < math.pi / 2
        px, py = to_local(next_lane.transform.location)
        offset = (py - y) * math.cos(heading) - (px - x) * math.sin(heading)
        kind = _KINDS.get(next_lane.lane_type)
        if kind is not None:
            direction = LaneDirection.SAME if is_same_direction else LaneDirection.OPPOSITE
            place = side * (len(lanes) + 1)
            lanes.append(
                AdjacentLane(place, kind, direction, offset, float(next_lane.lane_width), line_kind(marking, kind))
            )
        elif lanes and lanes[-1].kind is not LaneKind.DRIVING:
            # A strip without a kind beyond the roadside ends the road.
            break
        here = next_lane
        # Strips without a kind, such as medians, are skipped up to this distance from the route. Ours.
        if kind is None and abs(offset) > 30.0:
            break
    return lanes


def line_kind(marking: Any, into: LaneKind) -> LineKind:
    """Return the kind of a marking for a vehicle that crosses it from the route's side into a lane of kind `into`."""
    if into is LaneKind.SIDEWALK or (marking is not None and marking.type in _CURB):
        return LineKind.KERB
    if marking is None or marking.type in _NONE:
        return LineKind.NONE
    if marking.type in _BROKEN or marking.type == _NEAR_SIDE_BROKEN:
        return LineKind.BROKEN
    return LineKind.SOLID
