"""Walks along lanes of a `carla.Map` in steps of 1 m, and finds adjacent lanes."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import carla

from stucksolver_bridge.traffic_side import drives_on_left, inner_lane, outer_lane

_LOOK_AHEAD_M = 15.0
"""Distance ahead at which the heading of a fork's options is compared (m). Ours."""
_MAX_SIDE_LANES = 6
"""Maximum number of lanes on one side. Ours."""

Path = tuple["carla.Waypoint", ...]
"""Waypoints about 1 m apart, in driving direction."""


@dataclass(frozen=True)
class Town:
    """A map with its name, and cached queries."""

    name: str
    map: carla.Map

    @cached_property
    def limits_kmh(self) -> dict[tuple[int, int], float]:
        """Signed speed limits by (road id, sign of the lane ids: 1 for left lanes, -1 for right lanes)."""
        signs = self.map.get_all_landmarks_of_type("274")
        return {(sign.road_id, _sign(sign.get_lane_validities()[0][0])): sign.value for sign in signs}

    def limit_kmh(self, waypoint: carla.Waypoint) -> float:
        """Return the limit on a lane outside junctions; 0 without a sign."""
        return self.limits_kmh.get((waypoint.road_id, _sign(waypoint.lane_id)), 0.0)

    @cached_property
    def lanes(self) -> list[Path]:
        """All driving lanes outside junctions, each from start to end."""
        starts = {(w.road_id, w.lane_id): w for w, _ in self.map.get_topology() if not w.is_junction}
        return [_along(starts[key]) for key in sorted(starts)]

    @cached_property
    def lengths_m(self) -> dict[int, int]:
        """Lengths of roads outside junctions, by road id."""
        return {lane[0].road_id: len(lane) for lane in self.lanes}


def follow(waypoint: carla.Waypoint, length_m: int, through: Collection[int] = ()) -> Path:
    """Return this waypoint and those after it; at forks along a road in `through`, else straight on."""
    path = [waypoint]
    while len(path) <= length_m:
        options = path[-1].next(1.0)
        if not options:
            break
        wanted = [option for option in options if option.road_id in through]
        path.append((wanted or sorted(options, key=lambda option: _bend(path[-1], option)))[0])
    return tuple(path)


def approach(waypoint: carla.Waypoint, length_m: int) -> Path:
    """Return the waypoints before this one, as straight as possible, and itself last."""
    path = [waypoint]
    while len(path) <= length_m:
        options = path[-1].previous(1.0)
        if not options:
            break
        path.append(min(options, key=lambda option: abs(turn_deg(option, path[-1]))))
    return tuple(reversed(path))


def turn_deg(first: Any, second: Any) -> float:
    """Return the change of heading (degrees), positive to the right as in CARLA."""
    return float(math.remainder(second.transform.rotation.yaw - first.transform.rotation.yaw, 360.0))


def bend_deg(path: Sequence[Any]) -> float:
    """Return the largest change of heading from the first waypoint (degrees)."""
    return max(abs(turn_deg(path[0], item)) for item in path[::3])


def lane_to_right(waypoint: carla.Waypoint, kind: carla.LaneType) -> carla.Waypoint | None:
    """Return the nearest lane of a type toward the road's edge, or None."""
    lane = outer_lane(waypoint)
    for _ in range(_MAX_SIDE_LANES):
        if lane is None or lane.lane_type == kind:
            return lane
        lane = outer_lane(lane)
    return None


def same_way(waypoint: carla.Waypoint, side: carla.LaneChange) -> carla.Waypoint | None:
    """Return the adjacent driving lane on a side (`carla.LaneChange`) to which changes are permitted, or None.

    In left-hand traffic, the sides are mirrored.
    """
    if drives_on_left(waypoint):
        side = carla.LaneChange.Right if side == carla.LaneChange.Left else carla.LaneChange.Left
    if not waypoint.lane_change & side:
        return None
    lane = waypoint.get_left_lane() if side == carla.LaneChange.Left else waypoint.get_right_lane()
    if lane is None or lane.lane_type != carla.LaneType.Driving or lane.lane_id * waypoint.lane_id < 0:
        return None
    return lane


def oncoming(waypoint: carla.Waypoint) -> carla.Waypoint | None:
    """Return the adjacent oncoming driving lane across a broken line, or None."""
    lane = inner_lane(waypoint)
    if lane is None or lane.lane_type != carla.LaneType.Driving or lane.lane_id * waypoint.lane_id > 0:
        return None
    line = waypoint.right_lane_marking if drives_on_left(waypoint) else waypoint.left_lane_marking
    return lane if line is not None and line.type == carla.LaneMarkingType.Broken else None


def _along(waypoint: carla.Waypoint) -> Path:
    path = [waypoint]
    while True:
        following = path[-1].next(1.0)
        if len(following) != 1 or following[0].road_id != waypoint.road_id:
            return tuple(path)
        path.append(following[0])


def _bend(here: Any, option: Any) -> float:
    ahead = option.next(_LOOK_AHEAD_M)
    return abs(turn_deg(here, ahead[0] if ahead else option))


def _sign(lane_id: int) -> int:
    return 1 if lane_id > 0 else -1
