"""ParkedCarInLane."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.street import StreetScenario
from stucksolver_eval.scenarios.registry import scenario

CAR = "vehicle.tesla.model3"


@scenario
class ParkedCarInLane(StreetScenario):
    """An empty car without lights is parked in the middle of the hero's lane."""

    type = "ParkedCarInLane"
    starts = "the car is present from the start; the oncoming cars start with the hero"
    blueprints = (CAR,)

    def place_situation(self) -> None:
        self.cast.hold(self.cast.must_spawn(CAR, self.ahead(self.distance_m).transform))
