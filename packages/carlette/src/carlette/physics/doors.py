"""Open doors: boxes that stick out from a vehicle and take part in its contacts. The numbers are ours."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from carlette.geometry import Box, Floats
from carlette.physics.bodies import BodyTable
from carlette.physics.column_table import Table, flags, indices, numbers

SWING_S = 0.8
"""Time to open or close a door (s)."""
REACH_M = 0.9
"""Distance that an open door sticks out from the side (m)."""
DEPTH_M = 0.4
"""Length of an open door along the vehicle (m): it opens to about 65 degrees."""
SILL_M = 0.35
"""Height of a door's lower edge (m)."""
TOP_M = 1.25
"""Height of a door's upper edge (m)."""
ALL = 6
"""Number of CARLA for all doors."""


class DoorHinge(NamedTuple):
    """Hinge of a side door."""

    along: float
    """Front edge of the open door, in half lengths ahead of the box's center."""
    side: float
    """-1 left, +1 right."""
    reach_m: float = REACH_M


SIDE_DOORS = {0: DoorHinge(0.36, -1.0), 1: DoorHinge(0.36, 1.0), 2: DoorHinge(-0.08, -1.0), 3: DoorHinge(-0.08, 1.0)}
"""Hinges of the side doors: front left, front right, rear left, rear right.

Hood and trunk open upward and take no space on the road.
"""
STOP_ARM = 7
"""Number of the stop arm."""
ARM_PLACE = DoorHinge(0.5, -1.0, 0.5)
"""Hinge of a school bus's stop arm, which swings out on the left with the stop sign."""


@dataclass
class OpenDoors(Table):
    """One row for each side door that is not closed."""

    row: NDArray[np.int64] = field(default_factory=indices())
    """The vehicle's row in `BodyTable`."""
    door: NDArray[np.int64] = field(default_factory=indices())
    opening: NDArray[np.bool_] = field(default_factory=flags())
    """True while it opens or stays open; otherwise it closes."""
    swing: Floats = field(default_factory=numbers())
    """0 shut, 1 open."""
    hinge: Floats = field(default_factory=numbers(2))
    """Front edge on the vehicle's side, actor frame."""
    side: Floats = field(default_factory=numbers())
    reach: Floats = field(default_factory=numbers())
    """Distance that it sticks out when open (m)."""

    def move(self, row: int, box: Box, door: int, opening: bool) -> None:
        """Open or close one door (0 to 3), all (6) or the stop arm (7) of the vehicle at `row`."""
        places = {STOP_ARM: ARM_PLACE} if door == STOP_ARM else SIDE_DOORS
        for item in places if door == ALL else [door] * (door in places):
            here = np.flatnonzero((self.row == row) & (self.door == item))
            if len(here):
                self.opening[here] = opening
            elif opening:
                place = places[item]
                hinge = (
                    box.center.x + place.along * box.extent.x,
                    box.center.y + place.side * box.extent.y,
                )
                self.append(row=row, door=item, opening=True, hinge=hinge, side=place.side, reach=place.reach_m)

    def forget(self, row: int) -> None:
        """Remove the doors of a vehicle that leaves the world."""
        for index in reversed(np.flatnonzero(self.row == row).tolist()):
            self.delete(index)

    def step(self, dt: float) -> None:
        """Swing the doors."""
        change = np.where(self.opening, dt, -dt) / SWING_S
        self.swing = np.clip(self.swing + change, 0.0, 1.0)
        for index in reversed(np.flatnonzero(~self.opening & (self.swing <= 0.0)).tolist()):
            self.delete(index)

    def boxes(self, bodies: BodyTable) -> tuple[Floats, Floats]:
        """Return center and half sizes of each door's box, in the vehicle's frame."""
        reach = np.maximum(self.reach * self.swing, 0.01)
        base = bodies.center[self.row, 2] - bodies.extent[self.row, 2]
        center = np.stack(
            [
                self.hinge[:, 0] - DEPTH_M / 2,
                self.hinge[:, 1] + self.side * reach / 2,
                base + (SILL_M + TOP_M) / 2,
            ],
            axis=1,
        )
        half = np.stack([np.full(len(self), DEPTH_M / 2), reach / 2, np.full(len(self), (TOP_M - SILL_M) / 2)], axis=1)
        return center, half
