"""AllWayStopDeadlock."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from stucksolver.evaluate.actors import Car
from stucksolver.evaluate.scenarios.moves.junction import JunctionScenario, straight_way
from stucksolver.evaluate.scenarios.registry import scenario
from stucksolver.evaluate.scenarios.setting import Setting

BEFORE_M, NOSE_MPS, NOSE_GAP_M, FARTHEST_M = 2.0, 6.0, 1.0, 30.0
NEAR_M, STANDS_S, CREPT_M = 45.0, 4.0, 0.5
STANDING_MPS = 0.1


@scenario
class AllWayStopDeadlock(JunctionScenario):
    """Four cars at an all-way stop wait for each other, one with its nose in the hero's way, until somebody creeps."""

    type = "AllWayStopDeadlock"
    expected = "recover"
    timeout_s = None
    suspends = frozenset({"blocked"})
    starts = "the others stand from the trigger on; once the hero has stood for 4 s and then crept half a metre they go"
    needs_map = "a junction on the route with a road from the right"

    def needs(self, setting: Setting) -> str | None:
        missing = super().needs(setting)
        if missing is None and not self.entries_from("right"):
            missing = "at the hero's next junction nobody can come from the right"
        return missing

    def script(self) -> Iterator[None]:
        sides = [entries[0] for side in ("right", "left", "opposite") if (entries := self.entries_from(side))]
        self.traffic.handle_junction_scenario(remove_entries=sides)
        cars = []
        for entry in sides:
            line = self.approach(entry, BEFORE_M, 40.0, straight_way)
            member = self.cast.must_spawn(self.cast.some_car(self.random), line[0].transform)
            cars.append(self.cars.drive(member, line, 0.0, begin=False, yields=False))
        yield from self.until(lambda: self.gap_m(self.entry_s) < NEAR_M)
        cars[0].wish_mps = NOSE_MPS
        yield from self.until(lambda: self._in_the_way(cars[0]))
        cars[0].wish_mps, cars[0].brakes_hard = 0.0, True
        yield from self._hero_creeps()
        for car in cars:
            car.wish_mps, car.yields = self.limit_mps, True
            yield from self.wait(3.0)
        yield from self.until_passed(self.exit_s + 10.0)

    def _in_the_way(self, car: Car) -> bool:
        """Whether the car's nose has come to the hero's way."""
        state, reach_m = car.state, car.member.half_length_m
        x, y = state.x + reach_m * math.cos(state.yaw_rad), state.y + reach_m * math.sin(state.yaw_rad)
        inside = self.setting.route.xyz[self.junction.first : self.junction.last + 1, :2]
        return car.s > FARTHEST_M or float(np.hypot(inside[:, 0] - x, inside[:, 1] - y).min()) < NOSE_GAP_M

    def _hero_creeps(self) -> Iterator[None]:
        """Until the hero has stood for a while and then moved on a little, or is through."""
        stood_since_s, from_s = None, 0.0
        while self.setting.hero_s_m < self.exit_s:
            if stood_since_s is None and self.hero.speed_mps < STANDING_MPS:
                stood_since_s, from_s = self.cast.time_s, self.setting.hero_s_m
            if stood_since_s is not None and self._has_moved(from_s):
                if self.cast.time_s - stood_since_s > STANDS_S:
                    return
                stood_since_s = None
            yield

    def _has_moved(self, from_s: float) -> bool:
        return self.setting.hero_s_m - from_s > CREPT_M
