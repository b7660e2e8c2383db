"""Keeps vehicles, walkers and props on the road's surface. The numbers are ours."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from carlette.geometry import Floats, Vector
from carlette.opendrive.road_network import RoadNetwork
from carlette.physics.bodies import BodyTable
from carlette.physics.column_table import Table, flags, indices, numbers
from carlette.physics.vehicle_dynamics import GRAVITY

STEP_M = 0.3
"""Distance after which the map is queried again for a walker (m)."""
RELOOK_M = 1.5
"""The same distance for other actors (m). In between the surface is a plane."""
STAGED_M = 1.0
"""Depth below the road from which an actor counts as staged there on purpose (m). It stays where it is."""
CONTACT_M = 0.02
"""Height above the ground up to which an actor is on it (m)."""
JUMP_MPS = 2.0
"""Upward speed above which an actor leaves the ground (m/s). Slower ones stay on it."""


@dataclass
class Surface(Table):
    """One row for each actor on the ground: the plane below it."""

    row: NDArray[np.int64] = field(default_factory=indices())
    """The actor's row in `BodyTable`."""
    origin: Floats = field(default_factory=numbers(3))
    slope: Floats = field(default_factory=numbers(2))
    """Rise in z for each meter of x and of y."""
    looked: Floats = field(default_factory=numbers(2))
    """Position of the last query of the map; infinity if there was none."""
    stand: Floats = field(default_factory=numbers())
    """Height of the actor's origin above the ground when it is on the ground (m)."""
    tilts: NDArray[np.bool_] = field(default_factory=flags())
    """True if pitch and roll follow the surface (vehicles)."""
    on_foot: NDArray[np.bool_] = field(default_factory=flags())
    """True if it steps onto curbs (walkers). The map is queried at every step."""
    weightless: NDArray[np.bool_] = field(default_factory=flags())
    """True if a client switched gravity off."""

    def add(self, row: int, stand_m: float, tilts: bool, on_foot: bool = False) -> int:
        """Add the actor at `row` of `BodyTable`."""
        return self.append(row=row, stand=stand_m, tilts=tilts, on_foot=on_foot, looked=(np.inf, np.inf))

    def airborne(self, bodies: BodyTable) -> NDArray[np.bool_]:
        """(rows,): True for actors that are not on the ground."""
        up: NDArray[np.bool_] = bodies.position[self.row, 2] - self._ground(bodies.position[self.row]) > CONTACT_M
        return up

    def update(self, bodies: BodyTable, roads: RoadNetwork) -> None:
        """Query the map for the planes below the actors that have moved on."""
        position = bodies.position[self.row]
        near = np.where(self.on_foot, STEP_M, RELOOK_M)
        gap = np.abs(position[:, :2] - self.looked)
        moved = (gap[:, 0] > near) | (gap[:, 1] > near)
        if not moved.any():
            return
        which = moved.nonzero()[0]
        grounds = [roads.ground(Vector(*point)) for point in position[which].tolist()]
        self.origin[which] = [ground.origin for ground in grounds]
        self.origin[which, 2] += np.array([ground.curb_m for ground in grounds]) * self.on_foot[which]
        self.slope[which] = [(ground.slope_x, ground.slope_y) for ground in grounds]
        self.looked[which] = position[which, :2]

    def settle(self, bodies: BodyTable, dt: float) -> None:
        """Let actors fall onto, and follow, the ground below them."""
        row = self.row
        position, slope = bodies.position[row], self.slope
        ground = self._ground(position)
        height = position[:, 2] - ground
        active = bodies.simulated[row] & (height > -STAGED_M)
        velocity = bodies.velocity[row]
        along = velocity[:, 0] * slope[:, 0] + velocity[:, 1] * slope[:, 1]
        rising = velocity[:, 2] - along > JUMP_MPS
        falling = active & ((height > CONTACT_M) | rising)
        climb = velocity[:, 2] - GRAVITY * dt * ~self.weightless
        fallen = np.maximum(position[:, 2] + climb * dt, ground)
        new_z = np.where(falling, fallen, np.where(active, ground, position[:, 2]))
        bodies.position[row, 2] = new_z
        landed = new_z <= ground
        bodies.velocity[row, 2] = np.where(falling & ~landed, climb, np.where(active, along, 0.0))
        self._tilt(bodies, active & self.tilts)

    def _ground(self, position: Floats) -> Floats:
        """Return the height of each actor's origin if it is on the ground at its position (m)."""
        rise = (position[:, :2] - self.origin[:, :2]) * self.slope
        level: Floats = self.origin[:, 2] + (rise[:, 0] + rise[:, 1]) + self.stand
        return level

    def _tilt(self, bodies: BodyTable, which: NDArray[np.bool_]) -> None:
        row = self.row[which]
        yaw = np.radians(bodies.rotation[row, 1])
        cos, sin = np.cos(yaw), np.sin(yaw)
        slope = self.slope[which]
        bodies.rotation[row, 0] = np.degrees(np.arctan(slope[:, 0] * cos + slope[:, 1] * sin))
        bodies.rotation[row, 2] = np.degrees(np.arctan(slope[:, 0] * sin - slope[:, 1] * cos))
