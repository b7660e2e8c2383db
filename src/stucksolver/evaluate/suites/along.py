"""Sites along a lane, away from junctions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import carla

from stucksolver.evaluate.suites.site import Site
from stucksolver.evaluate.suites.walk import Path, Town, bend_deg, beside, oncoming, same_way

_STRAIGHT_DEG = 12.0
_STEP_M = 20
_MARK_EVERY_M = 60
_MARGIN_M = 6
_LONGEST_M = 280
_WIDE_M = 3.0
_TWO_WAYS_LIMIT_KMH = 50.0
"""Faster oncoming flows leave no gap that one can overtake in from standing."""
_SURE_BEND_DEG = 15.0

Fits = Callable[[Town, Path], bool]
"""Whether a stretch, from the trigger on, has what the scenario needs."""


@dataclass(frozen=True)
class Along:
    """What a type needs of a lane."""

    fits: Fits
    after_m: int
    """Free lane after the trigger."""
    before_m: int = 28
    """From the route's start to the trigger, on the same road."""
    behind_m: int = 0
    """More of the lane before the route's start."""
    direct: bool = True
    """Whether the stretch must be straight."""


def sites(need: Along, town: Town) -> Iterator[Site]:
    """All places of a map that fit, one every 20 m of each lane."""
    for lane in town.lanes:
        if lane[0].lane_width < _WIDE_M:
            continue
        last = len(lane) - need.after_m - _MARGIN_M
        for start in range(need.behind_m + need.before_m + _MARGIN_M, last + 1, _STEP_M):
            stretch = lane[start : start + need.after_m]
            if need.direct and bend_deg(stretch) > _STRAIGHT_DEG:
                continue
            if need.fits(town, stretch):
                yield _site(need, town, lane, start)


def _site(need: Along, town: Town, lane: Path, start: int) -> Site:
    first, trigger = start - need.before_m, lane[start]
    path = lane[first : min(len(lane) - _MARGIN_M, first + _LONGEST_M)]
    name = f"{trigger.road_id}/{trigger.lane_id}"
    marks = (*path[:-_MARK_EVERY_M:_MARK_EVERY_M], path[-1])
    return Site(town, name, f"{name}@{start}", path, marks, trigger, free_m=len(lane) - start - _MARGIN_M)


def _any_lane(town: Town, stretch: Path) -> bool:
    return True


def _left_lane(town: Town, stretch: Path) -> bool:
    """The rightmost of several lanes."""
    return all(same_way(w, carla.LaneChange.Left) and not same_way(w, carla.LaneChange.Right) for w in _ends(stretch))


def _right_lane(town: Town, stretch: Path) -> bool:
    """A lane with another to its right."""
    return all(same_way(w, carla.LaneChange.Right) for w in _ends(stretch))


def _several_lanes(town: Town, stretch: Path) -> bool:
    return _left_lane(town, stretch) or _right_lane(town, stretch)


def _two_ways(town: Town, stretch: Path) -> bool:
    """One lane each way, where passing is permitted and traffic is not fast."""
    slow = 0.0 < town.limit_kmh(stretch[0]) <= _TWO_WAYS_LIMIT_KMH
    return slow and all(oncoming(w) and not same_way(w, carla.LaneChange.Right) for w in _ends(stretch))


def _parking(town: Town, stretch: Path) -> bool:
    lanes = [w.get_right_lane() for w in _ends(stretch)]
    return all(lane is not None and lane.lane_type == carla.LaneType.Parking for lane in lanes)


def _two_ways_with_parking(town: Town, stretch: Path) -> bool:
    return _two_ways(town, stretch) and _parking(town, stretch)


def _sidewalk(town: Town, stretch: Path) -> bool:
    """A sidewalk to the right that no parked car hides."""
    if same_way(stretch[0], carla.LaneChange.Right) or _parking(town, stretch):
        return False
    return all(beside(w, carla.LaneType.Sidewalk) for w in _ends(stretch))


def _bend(town: Town, stretch: Path) -> bool:
    """One lane each way that turns; a solid centre line is the rule there."""
    left: Any = stretch[0].get_left_lane()
    both = left is not None and left.lane_type == carla.LaneType.Driving and left.lane_id * stretch[0].lane_id < 0
    slow = 0.0 < town.limit_kmh(stretch[0]) <= _TWO_WAYS_LIMIT_KMH
    both = both and not same_way(stretch[0], carla.LaneChange.Right)
    return both and slow and bend_deg(stretch[:60]) >= _SURE_BEND_DEG


def _ends(stretch: Path) -> Path:
    return (stretch[0], stretch[len(stretch) // 2], stretch[-1])


NEEDS: Mapping[str, Along] = {
    "Accident": Along(_left_lane, 125),
    "AccidentTwoWays": Along(_two_ways, 150),
    "ConstructionObstacle": Along(_left_lane, 125),
    "ConstructionObstacleTwoWays": Along(_two_ways, 150),
    "ControlLoss": Along(_any_lane, 125, direct=False),
    "DynamicObjectCrossing": Along(_sidewalk, 125),
    "HardBreakRoute": Along(_any_lane, 125),
    "HazardAtSideLane": Along(_left_lane, 150),
    "HazardAtSideLaneTwoWays": Along(_two_ways, 180),
    "InvadingTurn": Along(_bend, 125, direct=False),
    "ParkedObstacle": Along(_left_lane, 125),
    "ParkedObstacleTwoWays": Along(_two_ways, 150),
    "ParkingCrossingPedestrian": Along(_parking, 125),
    "ParkingCutIn": Along(_parking, 125),
    "ParkingExit": Along(_parking, 150, before_m=0, behind_m=20),
    "StaticCutIn": Along(_right_lane, 185),
    "VehicleOpensDoorTwoWays": Along(_two_ways_with_parking, 150),
    "YieldToEmergencyVehicle": Along(_several_lanes, 180, before_m=45, direct=False),
}
"""Scenario type to what it needs."""
