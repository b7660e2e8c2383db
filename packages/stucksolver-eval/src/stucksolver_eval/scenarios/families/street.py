"""The base of the street scenarios of `demo` and `cases`: one situation until the route's end, and oncoming cars."""

from __future__ import annotations

from collections.abc import Iterator

import carla

from stucksolver_eval.actors import Car
from stucksolver_eval.background_traffic.lanes import oncoming_lanes
from stucksolver_eval.scenarios.families.lane_places import run_of_lane, upstream
from stucksolver_eval.scenarios.parameters import NumberParameter
from stucksolver_eval.scenarios.scenario import Scenario

FIRST_M = 60.0
"""Distance of the first oncoming car beyond the situation (m). Ours."""
SPACING_M = 40.0
"""Distance between oncoming cars (m). Ours."""


def into_gear(vehicle: carla.Vehicle) -> None:
    """Put a new vehicle into first gear on the next tick, before any other control is applied.

    Otherwise its first throttle takes effect only after a second in CARLA, which would look like a stop.
    """
    vehicle.apply_control(carla.VehicleControl(manual_gear_shift=True, gear=1))


class StreetScenario(Scenario):
    """Base: the situation is `distance` beyond the trigger; `oncoming` cars come toward the hero, and no others."""

    timeout_s = None
    suspends = frozenset({"wrong_lane"})
    distance_m = NumberParameter("distance", 70.0, "m")
    oncoming = NumberParameter("oncoming", 0.0, "cars")

    def stage(self) -> None:
        """Place the situation, then the oncoming cars, nearest first."""
        into_gear(self.setting.hero)
        self.place_situation()
        self._coming: list[Car] = []
        lanes = oncoming_lanes(self.ahead(self.distance_m))
        for k in range(round(self.oncoming) if lanes else 0):
            start = upstream(lanes[0], FIRST_M + SPACING_M * k)
            # If the lane is too short, the last cars have no space and are omitted.
            car = self.cast.spawn(self.cast.some_car(self.random), start.transform, role="background")
            if car is not None:
                line = run_of_lane(start, self.setting.route.length_m + FIRST_M + SPACING_M * k)
                self._coming.append(self.cars.drive(car, line, self.limit_mps, begin=False, ends=True))

    def place_situation(self) -> None:
        """Place the situation."""

    def script(self) -> Iterator[None]:
        while not self.at_route_end():
            # Passed cars are removed before they come around the block again.
            gone = [car for car in self._coming if car.done]
            self.cars.remove(gone)
            self._coming = [car for car in self._coming if car not in gone]
            yield
