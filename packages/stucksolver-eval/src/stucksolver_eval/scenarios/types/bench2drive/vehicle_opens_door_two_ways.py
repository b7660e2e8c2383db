"""VehicleOpensDoorTwoWays."""

from __future__ import annotations

from collections.abc import Iterator

import carla

from stucksolver_eval.actors.actor_pool import LIFT_M
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.lane_places import door_to_lane, lane_of, offset_pose
from stucksolver_eval.scenarios.families.obstacle import PAST_M, TwoWayObstacle
from stucksolver_eval.scenarios.parameters import NumberParameter
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import two_ways_with_parking
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw, IntervalDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

OPENS_S = 3.0
"""Time of the hero to the car at which the door opens (s)."""
OPENS_M = 10.0
"""Distance of the hero at which the door opens in any case (m)."""
EDGE_M = 0.05
"""Distance of the car from the lane's edge (m)."""


@scenario
class VehicleOpensDoorTwoWays(TwoWayObstacle):
    """A parked car opens its door into the hero's lane; the hero must swing out in a gap of the oncoming flow."""

    type = "VehicleOpensDoorTwoWays"
    placed = SuitePlacement(
        "bench220",
        1400,
        LaneSites(two_ways_with_parking, 150),
        {"distance": IntegerDraw(37, 59), "frequency": IntervalDraw((25, 40), (85, 100))},
    )
    driver_alone = "collision: touches the open door"
    starts = "the door opens when the hero is 3 s or 10 m away; the oncoming flow starts 5 s later"
    needs_map = "a parking lane next to the hero's, and an oncoming lane"
    distance_m = NumberParameter("distance", 50.0, "m")

    def needs(self, setting: ScenarioContext) -> str | None:
        if lane_of(self.ahead(self.distance_m), carla.LaneType.Parking, self.direction) is None:
            return f"{self.distance_m:.0f} m beyond the trigger point there is no parking lane on the {self.direction}"
        if not self._cars_with_doors():
            return "the blueprint library has no car with doors that open"
        return super().needs(setting)

    def place_obstacle(self) -> tuple[float, float]:
        lane = lane_of(self.ahead(self.distance_m), carla.LaneType.Parking, self.direction)
        assert lane is not None
        self._car = self.cast.must_spawn(self.random.choice(self._cars_with_doors()), lane.transform)
        # The car is at the edge of the hero's lane, so that the door reaches into the lane.
        aside_m = max(lane.lane_width / 2.0 - self._car.half_width_m - EDGE_M, 0.0)
        self.cast.teleport(self._car, offset_pose(lane, -aside_m, up_m=LIFT_M))
        self.cast.hold(self._car)
        return self.distance_m, self.distance_m

    def script(self) -> Iterator[None]:
        self.clear_lane()
        place_s = self.s_at(self.distance_m)
        yield from self.until(lambda: self.within(place_s, OPENS_S, OPENS_M))
        self.cast.open_door(self._car, door_to_lane(self.ahead(self.distance_m), self.direction))
        self.traffic.stop_back()
        yield from self.wait(self.settle_s)
        yield from self.way_past(place_s + PAST_M)
        self.traffic.start_back()

    def _cars_with_doors(self) -> list[str]:
        moving = set(self.cast.kinds(has_dynamic_doors="true"))
        return [car for car in self.new_cars() if car in moving]
