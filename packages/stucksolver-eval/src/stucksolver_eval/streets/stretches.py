"""Lanes between junctions as chains of waypoints, split where the adjacent lanes change."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate, groupby, pairwise
from typing import Literal, TypeGuard

import carla

from stucksolver_bridge.traffic_side import drives_on_left, inner_lane, outer_lane

_STEP_M = 1.0
"""Distance between waypoints (m)."""
_MIN_LANE_M = 2.75
"""Smallest width of a lane for passing (m). Ours."""
_LONGEST = 5000
"""Maximum number of waypoints of a lane. Ours."""
StreetKind = Literal["one_lane", "multi_lane"]
Line = Literal["broken", "solid", "none", "other"]
_LaneKey = tuple[int, int, int]


@dataclass(frozen=True)
class Stretch:
    """Part of a chain, `first` to `last`, along which the neighbors stay the same."""

    kind: StreetKind
    center_line: Line
    """The line to the left neighbor."""
    rightmost: bool
    """True if there is no driving lane to the right."""
    first: int
    last: int


def lane_runs(carla_map: carla.Map) -> list[list[carla.Waypoint]]:
    """Return every driving lane from junction to junction as waypoints 1 m apart, in a fixed order."""
    entries = {_key(start): start for start, _ in carla_map.get_topology() if not start.is_junction}
    ordered = sorted(entries, key=lambda key: (not _follows_junction(entries[key]), key))
    visited: set[_LaneKey] = set()
    return [_chain(entries[key], visited) for key in ordered if key not in visited and _drivable(entries[key])]


def stretches(chain: Sequence[carla.Waypoint]) -> Iterator[Stretch]:
    """Yield the parts of a chain with a left neighbor lane for passing."""
    for neighbors, group in groupby(enumerate(chain), key=lambda item: _neighbors(item[1])):
        places = [place for place, _ in group]
        if neighbors is not None:
            yield Stretch(*neighbors, first=places[0], last=places[-1])


def bend_deg(waypoints: Sequence[carla.Waypoint]) -> float:
    """Return the largest change of heading between any two of these consecutive waypoints (degrees)."""
    return turn_deg([yaw_deg(waypoint) for waypoint in waypoints])


def turn_deg(yaws_deg: Sequence[float]) -> float:
    """Return the largest change between any two of these consecutive headings (degrees)."""
    turns = [math.remainder(after - before, 360.0) for before, after in pairwise(yaws_deg)]
    headings = list(accumulate(turns, initial=0.0))
    return max(headings) - min(headings)


def yaw_deg(waypoint: carla.Waypoint) -> float:
    """Return the heading of a waypoint (degrees)."""
    return waypoint.transform.rotation.yaw


def slope_deg(waypoint: carla.Waypoint) -> float:
    """Return the slope of a waypoint, -180 to 180 degrees."""
    return math.remainder(waypoint.transform.rotation.pitch, 360.0)


def _chain(start: carla.Waypoint, visited: set[_LaneKey]) -> list[carla.Waypoint]:
    """Follow a lane up to a junction, a fork, its end, or a lane that was visited before."""
    chain, here = [start], _key(start)
    visited.add(here)
    while len(chain) < _LONGEST:
        following = chain[-1].next(_STEP_M)
        if len(following) != 1 or following[0].is_junction:
            break
        if _key(following[0]) != here:
            here = _key(following[0])
            if here in visited:
                break
            visited.add(here)
        chain.append(following[0])
    return chain


def _follows_junction(start: carla.Waypoint) -> bool:
    before = start.previous(_STEP_M / 2)
    return len(before) != 1 or before[0].is_junction


def _key(waypoint: carla.Waypoint) -> _LaneKey:
    return waypoint.road_id, waypoint.section_id, waypoint.lane_id


def _neighbors(waypoint: carla.Waypoint) -> tuple[StreetKind, Line, bool] | None:
    """Return (kind, center line, outermost), or None if there is no lane for passing."""
    inner, outer = inner_lane(waypoint), outer_lane(waypoint)
    if not _drivable(inner) or min(inner.lane_width, waypoint.lane_width) < _MIN_LANE_M:
        return None
    marking = waypoint.right_lane_marking if drives_on_left(waypoint) else waypoint.left_lane_marking
    line, outermost = _line(marking), not _drivable(outer)
    if inner.lane_id * waypoint.lane_id > 0:
        return None if line == "solid" else ("multi_lane", line, outermost)
    if outermost and not _drivable(outer_lane(inner)):
        return "one_lane", line, True
    return None


def _drivable(waypoint: carla.Waypoint | None) -> TypeGuard[carla.Waypoint]:
    return waypoint is not None and waypoint.lane_type == carla.LaneType.Driving


def _line(marking: carla.LaneMarking | None) -> Line:
    """Classify a line. Any line with a solid part counts as solid, because its side is not reported reliably."""
    if marking is None:
        return "none"
    name = str(marking.type).lower()
    if "solid" in name:
        return "solid"
    if "broken" in name:
        return "broken"
    return "none" if name == "none" else "other"
