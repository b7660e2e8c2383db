"""Sites along a lane, away from junctions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from stucksolver_eval.suites.fits import (
    Fits,
    any_lane,
    bend,
    left_lane,
    parking,
    right_lane,
    several_lanes,
    sidewalk,
    two_ways,
    two_ways_with_parking,
)
from stucksolver_eval.suites.site import Site
from stucksolver_eval.suites.walk import Path, Town, bend_deg

_STRAIGHT_DEG = 12.0
_STEP_M = 20
_MARK_EVERY_M = 60
_MARGIN_M = 6
_LONGEST_M = 280


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


NEEDS: Mapping[str, Along] = {
    "Accident": Along(left_lane, 125),
    "AccidentTwoWays": Along(two_ways, 150),
    "ConstructionObstacle": Along(left_lane, 125),
    "ConstructionObstacleTwoWays": Along(two_ways, 150),
    "ControlLoss": Along(any_lane, 125, direct=False),
    "DynamicObjectCrossing": Along(sidewalk, 125),
    "HardBreakRoute": Along(any_lane, 125),
    "HazardAtSideLane": Along(left_lane, 150),
    "HazardAtSideLaneTwoWays": Along(two_ways, 180),
    "InvadingTurn": Along(bend, 125, direct=False),
    "ParkedObstacle": Along(left_lane, 125),
    "ParkedObstacleTwoWays": Along(two_ways, 150),
    "ParkingCrossingPedestrian": Along(parking, 125),
    "ParkingCutIn": Along(parking, 125),
    "ParkingExit": Along(parking, 150, before_m=0, behind_m=20),
    "StaticCutIn": Along(right_lane, 185),
    "VehicleOpensDoorTwoWays": Along(two_ways_with_parking, 150),
    "YieldToEmergencyVehicle": Along(several_lanes, 180, before_m=45, direct=False),
}
"""Scenario type to what it needs."""
