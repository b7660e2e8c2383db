"""Pedestrians: they go where they are told, and are knocked aside when they are hit."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from carlette.geometry import Floats
from carlette.physics.bodies import Bodies
from carlette.world.table import Table, indices, numbers

TURN_DEG_PER_S = 720.0
SLIDE_MPS2 = 5.0
"""Friction of a knocked walker or a pushed prop on the road."""


@dataclass
class Walkers(Table):
    """One row for each walker."""

    row: NDArray[np.int64] = field(default_factory=indices())
    control: Floats = field(default_factory=numbers(5))
    """Direction x, y, z (world), speed in m/s, jump: as the client sent them."""
    push: Floats = field(default_factory=numbers(2))
    """Velocity from being hit, which wears off."""

    def step(self, bodies: Bodies, dt: float) -> None:
        """Moves all simulated walkers by `dt` seconds in the plane."""
        row = self.row
        active = bodies.simulated[row]
        control = np.where(np.isfinite(self.control), self.control, 0.0)
        direction = control[:, :2]
        length = np.hypot(direction[:, 0], direction[:, 1])
        unit = direction / np.maximum(length, 1e-6)[:, None]
        going = np.where(length > 1e-6, control[:, 3], 0.0)
        velocity = unit * going[:, None] + self.push
        velocity = np.where(active[:, None], velocity, 0.0)
        self.push = slowed(self.push, SLIDE_MPS2 * dt)
        heading = np.degrees(np.arctan2(unit[:, 1], unit[:, 0]))
        yaw = bodies.rotation[row, 1]
        turn = np.where(active & (going > 0), (heading - yaw + 180.0) % 360.0 - 180.0, 0.0)
        turn = np.clip(turn, -TURN_DEG_PER_S * dt, TURN_DEG_PER_S * dt)
        bodies.rotation[row, 1] = (yaw + turn + 180.0) % 360.0 - 180.0
        bodies.angular[row, 2] = turn / dt
        bodies.velocity[row, :2] = velocity
        bodies.position[row, :2] += velocity * dt
        bodies.record["walk_direction"][row] = control[:, :3]
        bodies.record["walk_speed"][row] = control[:, 3]
        bodies.record["walk_jump"][row] = control[:, 4] > 0

    def take_push(self, bodies: Bodies) -> None:
        """After a collision: what a walker moves beyond its own will wears off slowly."""
        control = np.where(np.isfinite(self.control), self.control, 0.0)
        direction = control[:, :2]
        unit = direction / np.maximum(np.hypot(direction[:, 0], direction[:, 1]), 1e-6)[:, None]
        self.push = bodies.velocity[self.row, :2] - unit * control[:, 3:4]


def slowed(velocity: Floats, loss_mps: float) -> Floats:
    """Rows of planar velocities, each shorter by `loss_mps` but never turned round."""
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    keep = np.maximum(speed - loss_mps, 0.0) / np.maximum(speed, 1e-9)
    shorter: Floats = velocity * keep[:, None]
    return shorter
