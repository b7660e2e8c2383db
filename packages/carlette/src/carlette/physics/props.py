"""Props that a car pushes away: cones, bins, boxes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from carlette.physics.bodies import BodyTable
from carlette.physics.column_table import Table, indices
from carlette.physics.walkers import SLIDE_MPS2, slowed

SPIN_KEPT = 0.8
"""Share of a pushed prop's yaw rate that remains after each tick. Ours."""


@dataclass
class LooseProps(Table):
    """One row for each movable prop."""

    row: NDArray[np.int64] = field(default_factory=indices())

    def step(self, bodies: BodyTable, dt: float) -> None:
        """Let pushed props slide until friction stops them."""
        row = self.row
        velocity = slowed(bodies.velocity[row, :2], SLIDE_MPS2 * dt)
        velocity[~bodies.simulated[row]] = 0.0
        bodies.velocity[row, :2] = velocity
        bodies.position[row, :2] += velocity * dt
        spin = np.where(bodies.simulated[row], bodies.angular[row, 2] * SPIN_KEPT, 0.0)
        spin[np.abs(spin) < 0.1] = 0.0
        bodies.angular[row, 2] = spin
        bodies.rotation[row, 1] += spin * dt
