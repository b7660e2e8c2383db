"""Pedestrians and animals: they walk as commanded, jump, and are knocked aside by impacts."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from carlette.geometry import Floats, Vector
from carlette.physics.bodies import BodyTable
from carlette.physics.column_table import Table, flags, indices, numbers

TURN_DEG_PER_S = 720.0
"""Largest yaw rate of a walker (degrees/s). Ours."""
SLIDE_MPS2 = 5.0
"""Friction of a knocked walker or a pushed prop on the road (m/s²). Ours."""
MOST_MPS = 40.96
"""Highest speed of a walker (m/s), to which CARLA clamps it (`MaxWalkSpeed`)."""
LEAP_MPS = 4.2
"""Upward speed of a jump (m/s): Unreal's default for characters."""
DEADLY_MPS = 2.0
"""Change of speed in an impact with a vehicle that kills a walker that is not invincible (m/s). Ours."""
LIES_S = 10.0
"""Time after which a dead walker leaves the world (s). Ours."""


class WalkerImpact(Protocol):
    """Two bodies, by their rows, and the impulse on the second."""

    @property
    def first(self) -> int:
        """Row of the first body."""

    @property
    def second(self) -> int:
        """Row of the second body."""

    @property
    def impulse(self) -> Vector:
        """N·s."""


@dataclass
class Walkers(Table):
    """One row for each walker."""

    row: NDArray[np.int64] = field(default_factory=indices())
    control: Floats = field(default_factory=numbers(5))
    """Direction x, y, z (world), speed in m/s, jump: as the client sent them."""
    push: Floats = field(default_factory=numbers(2))
    """Velocity from an impact, which decays."""
    jumped: NDArray[np.bool_] = field(default_factory=flags())
    """True if it has already jumped for the present command. The next jump needs the button released first."""
    mortal: NDArray[np.bool_] = field(default_factory=flags())
    """True if it is not invincible, so that a vehicle can kill it."""
    dead: NDArray[np.bool_] = field(default_factory=flags())
    dead_s: Floats = field(default_factory=numbers())

    def step(self, bodies: BodyTable, airborne: NDArray[np.bool_], dt: float) -> None:
        """Move all simulated walkers by `dt` seconds in the plane. Those in the air keep their velocity."""
        row = self.row
        active = bodies.simulated[row]
        unit, going = self._will()
        velocity = unit * going[:, None] + self.push
        velocity = np.where(active[:, None], velocity, 0.0)
        # There is no friction in the air.
        self.push = np.where(airborne[:, None], self.push, slowed(self.push, SLIDE_MPS2 * dt))
        heading = np.degrees(np.arctan2(unit[:, 1], unit[:, 0]))
        yaw = bodies.rotation[row, 1]
        turn = np.where(active & (going > 0), (heading - yaw + 180.0) % 360.0 - 180.0, 0.0)
        turn = np.clip(turn, -TURN_DEG_PER_S * dt, TURN_DEG_PER_S * dt)
        bodies.rotation[row, 1] = (yaw + turn + 180.0) % 360.0 - 180.0
        bodies.angular[row, 2] = turn / dt
        bodies.velocity[row, :2] = velocity
        bodies.position[row, :2] += velocity * dt
        wants = self.control[:, 4] > 0
        leaps = wants & ~self.jumped & ~airborne & active & ~self.dead
        bodies.velocity[row[leaps], 2] += LEAP_MPS
        self.jumped = wants & (self.jumped | leaps)
        self.dead_s += dt * self.dead
        bodies.record["walk_direction"][row] = np.where(np.isfinite(self.control[:, :3]), self.control[:, :3], 0.0)
        bodies.record["walk_speed"][row] = going
        bodies.record["walk_jump"][row] = wants

    def take_push(self, bodies: BodyTable) -> None:
        """After a collision, let the part of a walker's motion that was not commanded decay slowly."""
        unit, going = self._will()
        self.push = bodies.velocity[self.row, :2] - unit * going[:, None]

    def wound(self, bodies: BodyTable, hits: Sequence[WalkerImpact], cars: Set[int]) -> None:
        """Kill the mortal walkers that one of the `cars` (rows of vehicles) has hit hard."""
        for index in np.flatnonzero(self.mortal & ~self.dead).tolist():
            row = int(self.row[index])
            for hit in hits:
                other = hit.second if hit.first == row else hit.first if hit.second == row else -1
                change = float(np.hypot(hit.impulse.x, hit.impulse.y) / bodies.mass[row])
                if other in cars and change > DEADLY_MPS:
                    self.dead[index] = True

    def _will(self) -> tuple[Floats, Floats]:
        """Return each walker's commanded direction (unit vector) and speed (m/s); zero for dead ones."""
        control = np.where(np.isfinite(self.control), self.control, 0.0)
        direction = control[:, :2]
        length = np.hypot(direction[:, 0], direction[:, 1])
        unit = direction / np.maximum(length, 1e-6)[:, None]
        going = np.where((length > 1e-6) & ~self.dead, np.clip(control[:, 3], 0.0, MOST_MPS), 0.0)
        return unit, going


def slowed(velocity: Floats, loss_mps: float) -> Floats:
    """Return rows of planar velocities, each reduced by `loss_mps` but never reversed."""
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    keep = np.maximum(speed - loss_mps, 0.0) / np.maximum(speed, 1e-9)
    shorter: Floats = velocity * keep[:, None]
    return shorter
