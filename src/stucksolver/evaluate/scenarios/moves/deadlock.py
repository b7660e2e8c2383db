"""Everybody at a junction waits for everybody else, until the hero creeps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from stucksolver.evaluate.actors import Car
from stucksolver.evaluate.scenarios.base import Scenario
from stucksolver.evaluate.scenarios.moves.junction import JunctionScenario, straight_way
from stucksolver.evaluate.scenarios.setting import Setting

BEFORE_M, NOSE_GAP_M = 2.0, 1.5
HALF_CAR_M, STEP_M = 2.0, 2.0
"""Of the shortest cars, and between a line's points."""
STANDS_S, CREPT_M = 4.0, 0.5
STANDING_MPS = 0.1


def hero_creeps(scenario: Scenario, until_s: float) -> Iterator[None]:
    """Until the hero has stood for 4 s and then moved on half a metre, or has come to a place of its route."""
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
    """Base: cars stand on the other roads of the junction; the one from the right has its nose in the hero's way."""

    timeout_s = None
    starts = "the others stand from the trigger on; once the hero has stood for 4 s and then crept half a metre they go"
    needs_map = "a junction on the route with a road from the right, where the hero does not turn right"

    def needs(self, setting: Setting) -> str | None:
        missing = super().needs(setting)
        if missing is None and not self.entries_from("right"):
            missing = "at the hero's next junction nobody can come from the right"
        if missing is None and self.turn == "right":
            missing = "the hero turns right, where nobody from the right is in its way"
        return missing

    def script(self) -> Iterator[None]:
        sides = [entries[0] for side in ("right", "left", "opposite") if (entries := self.entries_from(side))]
        self.traffic.handle_junction_scenario(remove_entries=sides)
        cars = [self._wait_at(entry, with_nose=entry is sides[0]) for entry in sides]
        yield from hero_creeps(self, self.exit_s)
        for car in cars:
            car.wish_mps, car.yields = self.limit_mps, True
            yield from self.wait(3.0)
        yield from self.until_passed(self.exit_s + 10.0)

    def _wait_at(self, entry: Any, with_nose: bool) -> Car:
        """A car that stands before the junction, or with its nose where the hero wants to go."""
        line = self.approach(entry, BEFORE_M, 40.0, straight_way)
        kind = self.cast.some_car(self.random)
        if with_nose:
            line = line[self._nose_at(line) :]
        member = self.cast.must_spawn(kind, line[0].transform)
        return self.cars.drive(member, line, 0.0, begin=False, yields=False)

    def _nose_at(self, line: list[Any]) -> int:
        """Index of the line's point from which a car's nose reaches to the hero's way."""
        inside = self.setting.route.xyz[self.junction.first : self.junction.last + 1, :2]
        places = np.array([(w.transform.location.x, w.transform.location.y) for w in line])
        apart = np.hypot(places[:, None, 0] - inside[None, :, 0], places[:, None, 1] - inside[None, :, 1]).min(axis=1)
        return max(int(np.argmax(apart < NOSE_GAP_M)) - round(HALF_CAR_M / STEP_M), 0)
