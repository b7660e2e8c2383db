"""StaticCutIn."""

from __future__ import annotations

from collections.abc import Iterator

import carla

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.lane_places import side_driving_lane
from stucksolver_eval.scenarios.parameters import ChoiceParameter, NumberParameter
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.scenario import Scenario
from stucksolver_eval.sites.lane_requirements import right_lane
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import ON_THE_RIGHT, IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

APART_M = 11.0
"""Distance between the cars of the queue (m)."""
CARS, CUTTER = 6, 2
"""Number of cars in the queue, and index of the one that pulls out."""
SYNC_S = 2.7
"""Time of the hero to the car at which it pulls out (s)."""
NEAR_M = 15.0
"""Distance of the hero at which it pulls out in any case (m)."""
CUT_S = 3.0
"""Duration of the lane change (s)."""
AWAY_MPS = 60.0 / 3.6
"""Speed of the car after the lane change (m/s)."""
AWAY_M = 70.0
"""Distance that the car drives until the scenario ends (m)."""
CUT_MPS = 5.0
"""Speed of the car during the lane change (m/s)."""
LIMIT_S = 30.0
"""Time limit of the scenario after the lane change started (s)."""


@scenario
class StaticCutIn(Scenario):
    """A car pulls out of a queue in the adjacent lane into the hero's lane and drives away."""

    type = "StaticCutIn"
    placed = SuitePlacement(
        "bench220", 1340, LaneSites(right_lane, 185), {"distance": IntegerDraw(40, 45), "direction": ON_THE_RIGHT}
    )
    driver_alone = "completed: brakes"
    timeout_s = None
    starts = "the queue appears at the trigger; the car cuts in when the hero is 2.7 s or 15 m away"
    needs_map = "a driving lane of the hero's direction on the side that `direction` names"
    distance_m = NumberParameter("distance", 100.0, "m")
    direction = ChoiceParameter("direction", "right", options=("left", "right"))

    def needs(self, setting: ScenarioContext) -> str | None:
        for k in range(CARS):
            if side_driving_lane(self._queue_waypoint(k), self.direction) is None:
                return (
                    f"{self.distance_m + k * APART_M:.0f} m beyond the trigger there is no lane on the {self.direction}"
                )
        return None

    def _queue_waypoint(self, k: int) -> carla.Waypoint:
        return self.ahead(self.distance_m + k * APART_M)

    def stage(self) -> None:
        self._queue = [self.cast.keep_below(self.cast.some_car(self.random)) for _ in range(CARS)]

    def script(self) -> Iterator[None]:
        self.traffic.remove_road_lane(self._cutters_lane())
        self.traffic.leave_space_in_front(self.distance_m + CARS * APART_M)
        for k, member in enumerate(self._queue):
            lane = side_driving_lane(self._queue_waypoint(k), self.direction)
            assert lane is not None
            self.cast.bring(member, lane.transform)
            self.cast.hold(member)
        place_s = self.s_at(self.distance_m + CUTTER * APART_M)
        yield from self.until(lambda: self.within(place_s, SYNC_S, NEAR_M))
        lane = self._queue_waypoint(CUTTER)
        side = 1.0 if self.direction == "right" else -1.0
        merge = (side * lane.lane_width, CUT_S * CUT_MPS * 0.7)
        car = self.cars.drive(self._queue[CUTTER], lane, CUT_MPS, merge=merge, yields=False, begin=False)
        cut_s, limit_s = self.cast.time_s + CUT_S, self.cast.time_s + LIMIT_S
        yield from self.until(lambda: self.cast.time_s >= cut_s)
        car.wish_mps = AWAY_MPS
        yield from self.until(lambda: car.s > AWAY_M or self.cast.time_s > limit_s)
        self.cars.remove([car])
        self.cast.remove(self._queue)
        self.traffic.readd_road_lane(self._cutters_lane())

    def _cutters_lane(self) -> carla.Waypoint:
        lane = side_driving_lane(self._queue_waypoint(CUTTER), self.direction)
        assert lane is not None, "needs() was called"
        return lane
