"""An emergency vehicle that takes the hero's right of way at a junction."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.junction import JunctionScenario, straight_way
from stucksolver_eval.scenarios.parameters import ChoiceParameter

if TYPE_CHECKING:
    import carla

SPEED_MPS = 60.0 / 3.6
"""Speed of the vehicle (m/s)."""
UPSTREAM_M = 60.0
"""Length of its path before the junction (m)."""
SINK_M = 10.0
"""Length of its path after the junction (m)."""
SYNC_S = 2.2
"""Time of the hero to the conflict point at which the vehicle appears (s)."""
NEAR_M = 12.0
"""Distance of the hero to the conflict point at which the vehicle appears (m)."""
LEAD_M = SPEED_MPS * SYNC_S
TOGETHER_M = 2.0
"""Distance of two paths below which they conflict (m). Ours."""
Array = NDArray[np.float64]


class OppositeVehicle(JunctionScenario):
    """Base: an emergency vehicle appears and crosses the hero's path at constant speed, timed to meet the hero."""

    timeout_s = None
    starts = "the vehicle appears when the hero is 2.2 s or 12 m from where their paths cross"
    direction = ChoiceParameter("direction", "right", options=("left", "right", "opposite"))
    simplified = "the vehicle starts 2.2 s from where the paths cross, not 30 m from the junction, so that they do meet"
    signalized: ClassVar[bool] = False

    def needs(self, setting: ScenarioContext) -> str | None:
        missing = super().needs(setting)
        if missing is not None:
            return missing
        if not setting.cast.kinds(special_type="emergency"):
            return "the blueprint library has no emergency vehicle"
        if not self.entries_from(self.direction):
            return f"at the hero's next junction there is no road from the {self.direction} side"
        return None

    def stage(self) -> None:
        kind = self.random.choice(self.cast.kinds(special_type="emergency"))
        self._vehicle = self.cast.keep_below(kind)
        self._line = self._from_lead(
            self.approach(self.entries_from(self.direction)[0], UPSTREAM_M, SINK_M, straight_way)
        )

    def script(self) -> Iterator[None]:
        self.traffic.handle_junction_scenario(remove_entries=[self._line[0]])
        if self.signalized:
            self.hold_lights(green=self.own_lights)
        cross_s = self._cross_s()
        yield from self.until(lambda: self.within(cross_s, SYNC_S, NEAR_M))
        self.cast.bring(self._vehicle, self._line[0].transform)
        car = self.cars.drive(self._vehicle, self._line, SPEED_MPS, constant=True, ends=True)
        end_s = self.cast.time_s + 3.0 * (LEAD_M + SINK_M + 40.0) / SPEED_MPS
        yield from self.until(lambda: car.done or self.cast.time_s > end_s)
        self.cars.remove([car])
        self.free_lights()

    def _cross_s(self) -> float:
        """Return the arc length at which the paths meet, or have the smallest distance (m)."""
        first, apart = self._apart(self._line)
        return float(self.setting.route.s_m[first + _first_near(apart.min(axis=1))])

    def _from_lead(self, line: list[carla.Waypoint]) -> list[Any]:
        """Return the path from the point at which the vehicle is 2.2 s from the hero's path."""
        crosses = _first_near(self._apart(line)[1].min(axis=0))
        gone_m = 0.0
        for k in range(crosses, 0, -1):
            gone_m += line[k].transform.location.distance(line[k - 1].transform.location)
            if gone_m >= LEAD_M:
                return line[k - 1 :]
        return line

    def _apart(self, line: list[carla.Waypoint]) -> tuple[int, Array]:
        """Return the route index of the junction's first point, and the distances (m), shape (route points, line)."""
        first, last = max(self.junction.first - 2, 0), self.junction.last + 2
        hero = self.setting.route.xyz[first : last + 1, :2]
        other = np.array([_xy(w) for w in line])
        return first, np.hypot(hero[:, None, 0] - other[None, :, 0], hero[:, None, 1] - other[None, :, 1])


def _first_near(apart_m: Array) -> int:
    """Return the index of the first point at which two paths meet, or of the nearest one if they never do."""
    return int(np.argmax(apart_m < TOGETHER_M)) if (apart_m < TOGETHER_M).any() else int(np.argmin(apart_m))


def _xy(waypoint: carla.Waypoint) -> tuple[float, float]:
    place = waypoint.transform.location
    return place.x, place.y
