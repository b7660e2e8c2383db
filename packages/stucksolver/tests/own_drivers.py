"""Stand-in drivers that go on by themselves: one that waits, one that rams what stands, one that swings out."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stucksolver.plan import CONTINUE, Directive
from stucksolver.scene import TrackedObject
from worlds import World

CONTACT_PENALTY = 0.6
"""Factor of a driving score for each collision with a vehicle, as in CARLA's leaderboard."""
ROUTE_M = 200.0


@dataclass
class Driven(World):
    """A world with solid bodies: whoever drives against something stops there, and the contact is counted.

    Attributes:
        contacts: Number of contacts so far. Touching the same object again after leaving it counts anew.
    """

    contacts: int = 0
    touching: bool = False

    def drive(self, directive: Directive) -> None:
        """One tick; a motion into a solid body does not happen."""
        before = (self.x, self.y, self.yaw, self.clearance())
        super().drive(directive)
        hits = self.clearance() < 0.0 and self.clearance() < before[3]
        if hits:
            self.x, self.y, self.yaw, self.speed = *before[:3], 0.0
        self.contacts += hits and not self.touching
        self.touching = hits or (self.touching and self.clearance() < 0.3)

    def score(self, start_m: float) -> float:
        """Share of the route (%), reduced for each contact."""
        return min((self.x - start_m) / ROUTE_M, 1.0) * 100.0 * CONTACT_PENALTY**self.contacts

    def ahead(self) -> TrackedObject | None:
        """The nearest object in the ego's lane ahead."""
        near = [o for o in self.objects if abs(o.y_m) < 1.9 and o.x_m > self.x]
        return min(near, key=lambda o: o.x_m, default=None)


@dataclass
class Patient(Driven):
    """Waits behind whatever is in the way. It stands for no visible reason until `starts_s`."""

    starts_s: float = 0.0

    def go_on(self) -> None:
        if self.time_s < self.starts_s:
            self._settle(0.0)
        else:
            super().go_on()


@dataclass
class Ramming(Driven):
    """Sees nothing that stands: accelerates along its lane against it, and goes on pushing."""

    acceleration_mps2: float = 1.5

    def go_on(self) -> None:
        self.speed = min(max(self.speed, 0.0) + self.acceleration_mps2 * self.dt, self.cruise_mps)
        self.yaw += float(np.clip(-self.yaw - 0.3 * self.y, -0.4, 0.4)) * self.speed / 6.0 * self.dt
        self.x += self.speed * math.cos(self.yaw) * self.dt
        self.y += self.speed * math.sin(self.yaw) * self.dt


@dataclass
class SwingsOut(Driven):
    """Waits behind what stands for `patience_s` in its own control, then passes it on the left by itself."""

    patience_s: float = 20.0
    waited_s: float = 0.0
    aside_m: float = 3.5

    def go_on(self) -> None:
        ahead = self.ahead()
        near = ahead is not None and ahead.x_m - self.x < 25.0
        self.waited_s += self.dt if near and self.speed < 0.1 else 0.0
        if self.waited_s < self.patience_s:
            self.yaw = 0.0
            super().go_on()
            return
        beside = any(-8.0 < o.x_m - self.x < 14.0 for o in self.objects if abs(o.y_m) < 1.9)
        self.speed = min(max(self.speed, 0.0) + 1.0 * self.dt, 3.0)
        wanted = self.aside_m if beside else 0.0
        self.yaw += float(np.clip(np.clip(0.4 * (wanted - self.y), -0.7, 0.7) - self.yaw, -0.5, 0.5)) * self.dt * 3.0
        self.x += self.speed * math.cos(self.yaw) * self.dt
        self.y += self.speed * math.sin(self.yaw) * self.dt
        if not beside and abs(self.y) < 0.1:
            self.waited_s, self.yaw = 0.0, 0.0


def alone(world: Driven, seconds: float, every_tick: Callable[[World], None] | None = None) -> float:
    """Drive without the add-on; return the score."""
    start_m = world.x
    for _ in range(round(seconds / world.dt)):
        world.drive(CONTINUE)
        if every_tick is not None:
            every_tick(world)
    return world.score(start_m)
