"""ParkingExit."""

from __future__ import annotations

from collections.abc import Iterator

import carla

from stucksolver_eval.actors import Car
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.lane_places import lane_of
from stucksolver_eval.scenarios.parameters import ChoiceParameter, NumberParameter
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.scenario import Scenario
from stucksolver_eval.sites.lane_requirements import parking
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import ON_THE_RIGHT, IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

SPACING_M = 25.0
"""Distance between cars of the traffic (m)."""
ROOM_AHEAD_M = 60.0
"""Extra distance for cars that have passed the parked hero (m), so that they do not queue up next to it."""
SIDE_CAR_M = 50.0
"""Distance that the car next to the hero drives before it is removed (m)."""
ENDS_M = 15.0
"""Distance beyond the parked car at which the scenario ends (m)."""
HERO_LIFT_M = 0.2
"""Height above the road at which the hero is placed (m)."""


@scenario
class ParkingExit(Scenario):
    """The hero is parked between two parked cars and must pull out into traffic."""

    type = "ParkingExit"
    placed = SuitePlacement(
        "bench220",
        1280,
        LaneSites(parking, 150, before_m=0, behind_m=20),
        {
            "direction": ON_THE_RIGHT,
            "front_vehicle_distance": IntegerDraw(9, 9),
            "behind_vehicle_distance": IntegerDraw(9, 9),
        },
    )
    driver_alone = "completed: pulls out in a gap"
    starts = "at the start of the route; a car next to the hero drives off at the trigger"
    needs_map = "a parking lane next to the hero's at the trigger point"
    direction = ChoiceParameter("direction", "right", options=("left", "right"))
    front_m = NumberParameter("front_vehicle_distance", 20.0, "m")
    behind_m = NumberParameter("behind_vehicle_distance", 10.0, "m")

    def needs(self, setting: ScenarioContext) -> str | None:
        lane = lane_of(self.ahead(0.0), carla.LaneType.Parking, self.direction)
        if lane is None or lane.lane_id * self.ahead(0.0).lane_id < 0:
            return f"at the trigger point there is no parking lane on the hero's {self.direction}"
        if not lane.next(self.front_m) or not lane.previous(self.behind_m):
            return "the parking lane at the trigger point is too short"
        return None

    def stage(self) -> None:
        lane = lane_of(self.ahead(0.0), carla.LaneType.Parking, self.direction)
        assert lane is not None
        place = lane.transform
        place.location.z += HERO_LIFT_M
        self.cast.teleport(self.cast.hero_member, place)
        self.cast.flush()
        self._parked = []
        for where in (lane.next(self.front_m)[0], lane.previous(self.behind_m)[0]):
            self._parked.append(self.cast.must_spawn(self.cast.some_car(self.random), where.transform))
            self.cast.hold(self._parked[-1])
        self._side = self.cast.must_spawn(self.cast.some_car(self.random), self.ahead(0.0).transform)
        self.cast.hold(self._side)

    def script(self) -> Iterator[None]:
        self.traffic.change_road_behavior(spawn_m=SPACING_M, extra_space_m=ROOM_AHEAD_M)
        side: Car | None = self.cars.drive(self._side, self.ahead(0.0), self.limit_mps, begin=False)
        start_s = self.setting.hero_s_m
        while self.setting.hero_s_m < start_s + self.front_m + ENDS_M and not self.at_route_end():
            if side is not None and side.s > SIDE_CAR_M:
                self.cars.remove([side])
                side = None
            yield
        self.traffic.change_road_behavior()
        if side is not None:
            self.cars.remove([side])
