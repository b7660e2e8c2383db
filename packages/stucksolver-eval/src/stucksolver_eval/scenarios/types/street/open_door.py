"""OpenDoorInLane."""

from __future__ import annotations

import carla

from stucksolver_eval.scenarios.families.lane_places import beside
from stucksolver_eval.scenarios.families.street import StreetScenario
from stucksolver_eval.scenarios.registry import scenario

CAR = "vehicle.dodge.charger_2020"
RIGHT_M = 1.1


@scenario
class OpenDoorInLane(StreetScenario):
    """A car stands half in the hero's lane with its driver's door open into the lane."""

    type = "OpenDoorInLane"
    starts = "present from the start"
    blueprints = (CAR,)

    def put(self) -> None:
        car = self.cast.must_spawn(CAR, beside(self.ahead(self.distance_m), RIGHT_M))
        self.cast.hold(car)
        self.cast.open_door(car, carla.VehicleDoor.FL)
