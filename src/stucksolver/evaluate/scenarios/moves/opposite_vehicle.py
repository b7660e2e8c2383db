"""An emergency vehicle that takes the hero's right of way at a junction."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from stucksolver.evaluate.scenarios.moves.junction import JunctionScenario, straight_way
from stucksolver.evaluate.scenarios.parameters import Choice
from stucksolver.evaluate.scenarios.setting import Setting

SPEED_MPS = 60.0 / 3.6
SOURCE_M, SINK_M = 30.0, 10.0
SYNC_S, NEAR_M = 2.2, 12.0


class OppositeVehicle(JunctionScenario):
    """Base: it waits below the ground, and comes at constant speed so that it would meet the hero."""

    timeout_s = None
    starts = "the vehicle comes when the hero is 2.2 s or 12 m from where their ways cross"
    direction = Choice("direction", "right", options=("left", "right", "opposite"))
    signalized: ClassVar[bool] = False

    def needs(self, setting: Setting) -> str | None:
        missing = super().needs(setting)
        if missing is not None:
            return missing
        if not setting.cast.kinds(special_type="emergency"):
            return "the blueprint library has no emergency vehicle"
        if self.signalized and not self.own_lights:
            return "the hero has no traffic light at its next junction"
        if not self.entries_from(self.direction):
            return f"at the hero's next junction nobody can come from the {self.direction} side"
        return None

    def stage(self) -> None:
        kind = self.random.choice(self.cast.kinds(special_type="emergency"))
        self._vehicle = self.cast.keep_below(kind)
        self._line = self.approach(self.entries_from(self.direction)[0], SOURCE_M, SINK_M, straight_way)

    def script(self) -> Iterator[None]:
        self.traffic.handle_junction_scenario(remove_entries=[self._line[0]])
        if self.signalized:
            self.hold_lights(green=self.own_lights)
        cross_s = self._cross_s()
        yield from self.until(lambda: self.within(cross_s, SYNC_S, NEAR_M))
        self.cast.bring(self._vehicle, self._line[0].transform)
        car = self.cars.drive(self._vehicle, self._line, SPEED_MPS, constant=True, ends=True)
        end_s = self.cast.time_s + 3.0 * (SOURCE_M + SINK_M + 40.0) / SPEED_MPS
        yield from self.until(lambda: car.done or self.cast.time_s > end_s)
        self.cars.remove([car])
        self.free_lights()

    def _cross_s(self) -> float:
        """Where along the route the ways cross, or come nearest."""
        route = self.setting.route
        first, last = max(self.junction.first - 2, 0), self.junction.last + 2
        hero = route.xyz[first : last + 1, :2]
        other = np.array([_xy(w) for w in self._line])
        apart = np.hypot(hero[:, None, 0] - other[None, :, 0], hero[:, None, 1] - other[None, :, 1]).min(axis=1)
        return float(route.s_m[first + int(np.argmin(apart))])


def _xy(waypoint: Any) -> tuple[float, float]:
    place = waypoint.transform.location
    return place.x, place.y
