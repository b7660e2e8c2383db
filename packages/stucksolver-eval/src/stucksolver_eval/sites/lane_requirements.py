"""Requirements on a stretch of a lane: waypoints 1 m apart, from a scenario's trigger on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import carla

from stucksolver_bridge.traffic_side import inner_lane, outer_lane
from stucksolver_eval.sites.lane_walk import Path, Town, bend_deg, lane_to_right, oncoming, same_way

_TWO_WAYS_LIMIT_KMH = 50.0
"""Highest speed limit for passing in the oncoming lane (km/h).

Faster oncoming flows have no gap long enough for a pass from rest.
"""
_SURE_BEND_DEG = 15.0
"""Change of heading from which a lane counts as a bend (degrees). Ours."""
_WIDE_M = 3.0
"""Smallest width of a wide lane (m). Ours."""

Fits = Callable[[Town, Path], bool]
"""Returns True if a stretch satisfies the scenario's requirements."""


def any_lane(town: Town, stretch: Path) -> bool:
    """True for any lane, except where two cars cannot pass each other."""
    return not narrow(town, stretch)


def left_lane(town: Town, stretch: Path) -> bool:
    """True for the rightmost of several lanes."""
    return all(same_way(w, carla.LaneChange.Left) and not same_way(w, carla.LaneChange.Right) for w in _ends(stretch))


def right_of_two(town: Town, stretch: Path) -> bool:
    """True for the rightmost of exactly two lanes."""
    lanes = [same_way(w, carla.LaneChange.Left) for w in _ends(stretch)]
    return left_lane(town, stretch) and not any(same_way(w, carla.LaneChange.Left) for w in lanes if w is not None)


def right_lane(town: Town, stretch: Path) -> bool:
    """True for a lane with another to its right."""
    return all(same_way(w, carla.LaneChange.Right) for w in _ends(stretch))


def several_lanes(town: Town, stretch: Path) -> bool:
    """True for one of several lanes of the direction."""
    return left_lane(town, stretch) or right_lane(town, stretch)


def two_ways(town: Town, stretch: Path) -> bool:
    """True for one lane each way, where passing is permitted and the limit is at most 50 km/h."""
    slow = 0.0 < town.limit_kmh(stretch[0]) <= _TWO_WAYS_LIMIT_KMH
    return slow and all(oncoming(w) and not same_way(w, carla.LaneChange.Right) for w in _ends(stretch))


def parking(town: Town, stretch: Path) -> bool:
    """True if there is a parking lane to the right."""
    lanes = [outer_lane(w) for w in _ends(stretch)]
    return all(lane is not None and lane.lane_type == carla.LaneType.Parking for lane in lanes)


def two_ways_with_parking(town: Town, stretch: Path) -> bool:
    """True for one lane each way with a parking lane to the right."""
    return two_ways(town, stretch) and parking(town, stretch)


def sidewalk(town: Town, stretch: Path) -> bool:
    """True if there is a sidewalk to the right, not hidden by parked cars."""
    if same_way(stretch[0], carla.LaneChange.Right) or parking(town, stretch):
        return False
    return all(lane_to_right(w, carla.LaneType.Sidewalk) for w in _ends(stretch))


def two_ways_by_sidewalk(town: Town, stretch: Path) -> bool:
    """True for one lane each way, where passing is permitted, with a sidewalk to the right."""
    return two_ways(town, stretch) and sidewalk(town, stretch)


def bend(town: Town, stretch: Path) -> bool:
    """True for one lane each way in a bend, where the center line is usually solid."""
    slow = 0.0 < town.limit_kmh(stretch[0]) <= _TWO_WAYS_LIMIT_KMH
    return one_lane(town, stretch) and slow and bend_deg(stretch[:60]) >= _SURE_BEND_DEG


def one_lane(town: Town, stretch: Path) -> bool:
    """True for one wide lane each way, with any center line."""
    alone = not any(
        same_way(w, side) for w in _ends(stretch) for side in (carla.LaneChange.Left, carla.LaneChange.Right)
    )
    return alone and _has_oncoming(stretch) and not narrow(town, stretch)


def narrow(town: Town, stretch: Path) -> bool:
    """True for lanes on which two cars cannot pass each other."""
    return bool(stretch[0].lane_width < _WIDE_M)


def _has_oncoming(stretch: Path) -> bool:
    inner: Any = inner_lane(stretch[0])
    if inner is None or inner.lane_type != carla.LaneType.Driving:
        return False
    return bool(inner.lane_id * stretch[0].lane_id < 0)


def _ends(stretch: Path) -> Path:
    return (stretch[0], stretch[len(stretch) // 2], stretch[-1])
