"""OpenDoorInLane."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.lane_places import door_to_lane, offset_pose
from stucksolver_eval.scenarios.families.street import StreetScenario
from stucksolver_eval.scenarios.registry import scenario

CAR = "vehicle.dodge.charger_2020"
RIGHT_M = 1.1
"""Distance of the car from the lane's center to the right (m)."""


@scenario
class OpenDoorInLane(StreetScenario):
    """A car is stopped half in the hero's lane with its driver's door open into the lane."""

    type = "OpenDoorInLane"
    starts = "present from the start"
    blueprints = (CAR,)

    def place_situation(self) -> None:
        lane = self.ahead(self.distance_m)
        car = self.cast.must_spawn(CAR, offset_pose(lane, RIGHT_M))
        self.cast.hold(car)
        self.cast.open_door(car, door_to_lane(lane))
