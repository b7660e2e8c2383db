"""ParkingCutIn."""

from __future__ import annotations

from collections.abc import Iterator

import carla

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.lane_places import lane_of
from stucksolver_eval.scenarios.parameters import ChoiceParameter
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.scenario import Scenario
from stucksolver_eval.sites.lane_requirements import parking
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import ON_THE_RIGHT
from stucksolver_eval.sites.suite_placement import SuitePlacement

BLOCKER_M = 28.0
"""Distance of the first parked car beyond the trigger (m)."""
CUTTER_M = 35.0
"""Distance of the car that pulls out beyond the trigger (m)."""
CUT_MPS = 20.0 / 3.6
"""Speed of the car (m/s)."""
SYNC_S = 2.35
"""Time of the hero to the car at which it pulls out (s)."""
NEAR_M = 10.0
"""Distance of the hero at which the car pulls out in any case (m)."""
OVER_M = 9.0
"""Length over which the car changes to the lane (m)."""
ENDS_M = 30.0
"""Distance that the car drives until the scenario ends (m)."""


@scenario
class ParkingCutIn(Scenario):
    """A car pulls out of a row of parked cars directly in front of the hero."""

    type = "ParkingCutIn"
    placed = SuitePlacement("bench220", 1270, LaneSites(parking, 125), {"direction": ON_THE_RIGHT})
    driver_alone = "completed: brakes, a near miss"
    timeout_s = None
    starts = "the car pulls out when the hero is 2.35 s or 10 m away"
    needs_map = "a parking lane next to the hero's"
    direction = ChoiceParameter("direction", "right", options=("left", "right"))

    def needs(self, setting: ScenarioContext) -> str | None:
        for distance_m in (BLOCKER_M, CUTTER_M):
            lane = lane_of(self.ahead(distance_m), carla.LaneType.Parking, self.direction)
            if lane is None or lane.lane_id * self.ahead(distance_m).lane_id < 0:
                return f"{distance_m:.0f} m beyond the trigger there is no parking lane on the hero's {self.direction}"
        return None

    def stage(self) -> None:
        self._cars = []
        for distance_m in (BLOCKER_M, CUTTER_M):
            lane = lane_of(self.ahead(distance_m), carla.LaneType.Parking, self.direction)
            assert lane is not None
            self._cars.append(self.cast.must_spawn(self.cast.some_car(self.random), lane.transform))
            self.cast.hold(self._cars[-1])

    def script(self) -> Iterator[None]:
        place_s = self.s_at(CUTTER_M)
        yield from self.until(lambda: self.within(place_s, SYNC_S, NEAR_M))
        cutter = self._cars[1]
        lane = self.ahead(CUTTER_M)
        parking = self.cast.state(cutter)
        side = 1.0 if self.direction == "right" else -1.0
        right_m = side * parking.distance_m(lane.transform.location.x, lane.transform.location.y)
        car = self.cars.drive(cutter, lane, CUT_MPS, merge=(right_m, OVER_M), yields=False, begin=False)
        end_s = self.cast.time_s + 30.0
        yield from self.until(lambda: car.s > ENDS_M or self.cast.time_s > end_s)
        self.cars.remove([car])
        self.cast.remove(self._cars)
