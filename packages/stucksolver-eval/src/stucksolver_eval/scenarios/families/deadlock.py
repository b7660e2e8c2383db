"""A deadlock: all vehicles at a junction wait for each other until the hero creeps forward."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stucksolver_eval.actors import Car
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.junction import JunctionScenario, straight_way
from stucksolver_eval.scenarios.scenario import Scenario

if TYPE_CHECKING:
    import carla

BEFORE_M = 2.0
"""Distance of the waiting cars from the junction (m)."""
NOSE_GAP_M = 1.5
"""Distance of two paths below which they conflict (m)."""
HALF_CAR_M, STEP_M = 2.0, 2.0
"""Half the length of the shortest cars, and the spacing of a path's points."""
STANDS_S = 4.0
"""Time that the hero must be stopped before it creeps (s)."""
CREPT_M = 0.5
"""Distance that the hero must creep (m)."""
STANDING_MPS = 0.1
"""Speed below which the hero counts as stopped (m/s)."""


def hero_creeps(scenario: Scenario, until_s: float) -> Iterator[None]:
    """Script: wait until the hero was stopped for 4 s and then moved 0.5 m, or reaches arc length `until_s` (m)."""
    stood_since_s, from_s = None, 0.0
    while scenario.setting.hero_s_m < until_s:
        if stood_since_s is None and scenario.hero.speed_mps < STANDING_MPS:
            stood_since_s, from_s = scenario.cast.time_s, scenario.setting.hero_s_m
        if stood_since_s is not None and scenario.setting.hero_s_m - from_s > CREPT_M:
            if scenario.cast.time_s - stood_since_s > STANDS_S:
                return
            stood_since_s = None
        yield


class Deadlock(JunctionScenario):
    """Base: cars wait on the junction's other roads; the nose of the one from the right blocks the hero's path."""

    timeout_s = None
    starts = (
        "the others wait from the trigger on; they go when the hero was stopped for 4 s and then crept half a meter"
    )
    needs_map = "a junction on the route with a road from the right that crosses the hero's path"

    def needs(self, setting: ScenarioContext) -> str | None:
        missing = super().needs(setting)
        if missing is None and self.noser is None:
            missing = "at the hero's next junction no road from the right crosses the hero's path"
        return missing

    @cached_property
    def noser(self) -> carla.Waypoint | None:
        """The entry on the right whose path conflicts with the hero's, or None."""
        nearest = min(self.entries_from("right"), key=lambda entry: self._apart(self._line(entry)).min(), default=None)
        meets = nearest is not None and self._apart(self._line(nearest)).min() < NOSE_GAP_M
        return nearest if meets else None

    def script(self) -> Iterator[None]:
        others = [entries[0] for side in ("left", "opposite") if (entries := self.entries_from(side))]
        assert self.noser is not None, "needs() was called"
        sides = [self.noser, *others]
        self.traffic.handle_junction_scenario(remove_entries=sides)
        cars = [self._wait_at(entry, with_nose=entry is self.noser) for entry in sides]
        yield from hero_creeps(self, self.exit_s)
        for car in cars:
            car.wish_mps, car.yields = self.limit_mps, True
            yield from self.wait(3.0)
        yield from self.until_passed(self.exit_s + 10.0)

    def _wait_at(self, entry: carla.Waypoint, with_nose: bool) -> Car:
        """Spawn a car that is stopped before the junction, or with its nose in the hero's path."""
        line = self._line(entry)
        if with_nose:
            reaches = int(np.argmax(self._apart(line) < NOSE_GAP_M))
            line = line[max(reaches - round(HALF_CAR_M / STEP_M), 0) :]
        member = self.cast.must_spawn(self.cast.some_car(self.random), line[0].transform)
        return self.cars.drive(member, line, 0.0, begin=False, yields=False)

    def _line(self, entry: carla.Waypoint) -> list[Any]:
        return self.approach(entry, BEFORE_M, 40.0, straight_way)

    def _apart(self, line: list[carla.Waypoint]) -> NDArray[np.float64]:
        """Return the distance of each point from the hero's path through the junction (m), shape (n,)."""
        inside = self.setting.route.xyz[self.junction.first : self.junction.last + 1, :2]
        places = np.array([(w.transform.location.x, w.transform.location.y) for w in line])
        away = np.hypot(places[:, None, 0] - inside[None, :, 0], places[:, None, 1] - inside[None, :, 1])
        return np.asarray(away.min(axis=1))
