"""SlowCyclists."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.street import StreetScenario
from stucksolver_eval.scenarios.parameters import NumberParameter
from stucksolver_eval.scenarios.registry import scenario

BICYCLES = ("vehicle.diamondback.century", "vehicle.bh.crossbike")
APART_M = 5.0
"""Distance between the cyclists (m)."""


@scenario
class SlowCyclists(StreetScenario):
    """Two cyclists ride very slowly in the middle of the hero's lane until the end of the route."""

    type = "SlowCyclists"
    starts = "all start with the hero"
    blueprints = BICYCLES
    distance_m = NumberParameter("distance", 20.0, "m")
    speed_kmh = NumberParameter("speed", 9.0, "km/h")

    def place_situation(self) -> None:
        for k, blueprint in enumerate(BICYCLES):
            start = self.ahead(self.distance_m + k * APART_M)
            rider = self.cast.must_spawn(blueprint, start.transform)
            self.cars.drive(rider, start, self.speed_kmh / 3.6, yields=False, begin=False)
