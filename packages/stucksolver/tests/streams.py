"""A stream of cars in the lane beside an obstacle, whose drivers see only what is in their own path."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stucksolver.scene import EgoState, LineKind, TrackedObject
from worlds import LANE_M, World, straight_road, thing

ROAD = straight_road(left=LineKind.BROKEN, oncoming=None)
REACTION_S = 0.5
"""They watch a nose beside their lane (`EntryPolicy.watching_reaction_s`)."""
HALF_M = 4.6 / 2


@dataclass
class Stream(World):
    """Cars come up in the left lane at a steady speed; each brakes only for what is in its own path ahead."""

    pace_mps: float = 9.0
    spacing_m: float = 26.0
    ends_s: float = math.inf
    """No new car comes after this time."""
    accelerates_mps2: float = 3.5
    hardest_mps2: float = 0.0
    """The hardest that one of them has braked so far."""
    spawned: int = 0

    def ego(self) -> EgoState:
        ego = super().ego()
        limits = ego.limits.model_copy(update={"comfort_acceleration_mps2": self.accelerates_mps2})
        return ego.model_copy(update={"limits": limits})

    def fill(self, first_m: float) -> Stream:
        """Put cars on the whole road, one of them `first_m` along it."""
        for x in np.arange(first_m % self.spacing_m, 300.0, self.spacing_m):
            self._come(float(x))
        return self

    def drive(self, directive: object) -> None:
        super().drive(directive)  # type: ignore[arg-type]
        cars = sorted((o for o in self.objects if o.id.startswith("car")), key=lambda o: -o.x_m)
        others = [o for o in self.objects if not o.id.startswith("car")]
        moved: list[TrackedObject] = []
        for car in cars:
            if car.x_m < 395.0:
                moved.append(self._paced(car, moved[-1] if moved else None))
        self.objects = [*others, *moved]
        if self.time_s < self.ends_s and (not moved or moved[-1].x_m > self.spacing_m):
            self._come(0.0 if not moved else moved[-1].x_m - self.spacing_m)

    def _settle(self, wanted: float, turn: float = 1.0, braking: float = 6.0) -> None:
        """As quick as the slow vehicle that the guard expects, and a little quicker."""
        self.speed = max(self.speed, 0.0)
        most = 0.7 * self.accelerates_mps2 * self.dt
        self.speed = max(self.speed + float(np.clip(wanted - self.speed, -braking * self.dt, most)), 0.0)
        self.x += self.speed * turn * self.dt

    def _come(self, x: float) -> None:
        self.spawned += 1
        self.objects.append(thing(f"car{self.spawned}", x, LANE_M, speed=self.pace_mps))

    def _paced(self, car: TrackedObject, ahead: TrackedObject | None) -> TrackedObject:
        rooms = [] if ahead is None else [(ahead.x_m - car.x_m - 2 * HALF_M, ahead.vx_mps)]
        reach = abs(math.sin(self.yaw)) * 2.45 + math.cos(self.yaw) * 0.925
        if self.y + reach > LANE_M - 0.95 and self.y - reach < LANE_M + 0.95 and self.x + 2.45 > car.x_m - HALF_M:
            tail = self.x - 2.45 * math.cos(self.yaw)
            rooms.append((tail - car.x_m - HALF_M, self.speed))
        change = 1.5 if car.vx_mps < self.pace_mps else 0.0
        for room, pace in rooms:
            needed = (max(car.vx_mps - pace, 0.0) ** 2) / (2 * max(room - 1.0, 0.1))
            if needed > 2.0 and room > -2 * HALF_M:
                change = min(change, -min(needed, 8.0))
        self.hardest_mps2 = max(self.hardest_mps2, -change)
        speed = float(np.clip(car.vx_mps + change * self.dt, 0.0, self.pace_mps))
        return car.model_copy(update={"vx_mps": speed})
