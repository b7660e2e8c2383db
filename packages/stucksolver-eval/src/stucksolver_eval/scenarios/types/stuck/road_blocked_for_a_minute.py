"""RoadBlockedForAMinute."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.background_traffic.lanes import oncoming_lanes
from stucksolver_eval.scenarios.families.lane_places import run_of_lane
from stucksolver_eval.scenarios.families.stuck import StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

TRUCK, CAR = "vehicle.carlamotors.carlacola", "vehicle.lincoln.mkz_2020"
LASTS_S = 60.0
"""Time until the vehicles drive off (s)."""
CLEARS_MPS = 6.0
"""Speed of the vehicles (m/s)."""


@scenario
class RoadBlockedForAMinute(StuckScenario):
    """A truck and a car maneuver side by side and block the whole road; after a minute it is free: wait."""

    type = "RoadBlockedForAMinute"
    placed = SuitePlacement("immobilized", 3130, LaneSites(two_ways), {"distance": IntegerDraw(40, 48)})
    driver_alone = "completed: waits 62 s"
    expected = "wait"
    suspends = frozenset({"blocked"})
    starts = "the vehicles are present from the start, and drive off 60 s after the hero came within 25 m"
    needs_map = "one lane each way"
    blueprints = (TRUCK, CAR)

    def stage(self) -> None:
        self._mine = self.put_disabled(TRUCK)
        lanes = oncoming_lanes(self.ahead(self.distance_m))
        self._others = [(self.cast.must_spawn(CAR, lane.transform), lane) for lane in lanes]
        for member, _ in self._others:
            self.cast.hold(member)

    def situation(self) -> Iterator[None]:
        self.traffic.change_opposite_behavior(active=False)
        self.traffic.clear_opposite()
        yield from self.hero_near()
        yield from self.wait(LASTS_S)
        # The truck drives off ahead of the hero, the others past it.
        self.cars.drive(self._mine, self.ahead(self.distance_m), CLEARS_MPS, begin=False)
        for member, lane in self._others:
            self.cars.drive(member, run_of_lane(lane, 100.0), CLEARS_MPS, begin=False)
        self.traffic.change_opposite_behavior(active=True)
        yield
