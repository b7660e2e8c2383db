"""Position and motion of every actor: one row each, in the order of the snapshot."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from carlette.geometry import Floats, Pose, Rotation, Vector
from carlette.physics.column_table import Table, flags, numbers
from carlette.wire.snapshot import RECORD, Records


@dataclass
class BodyTable(Table):
    """Meters, degrees, seconds, in the world frame unless said otherwise."""

    position: Floats = field(default_factory=numbers(3))
    rotation: Floats = field(default_factory=numbers(3))
    """Pitch, yaw, roll."""
    velocity: Floats = field(default_factory=numbers(3))
    angular: Floats = field(default_factory=numbers(3))
    """Degrees per second about x, y, z."""
    acceleration: Floats = field(default_factory=numbers(3))
    center: Floats = field(default_factory=numbers(3))
    """Center of the bounding box, actor frame."""
    extent: Floats = field(default_factory=numbers(3))
    clearance: Floats = field(default_factory=numbers())
    """Ground clearance (m). Lower objects pass under the body."""
    mass: Floats = field(default_factory=numbers())
    """Mass (kg); 0 = immovable."""
    solid: NDArray[np.bool_] = field(default_factory=flags())
    """True if the actor takes part in collisions."""
    simulated: NDArray[np.bool_] = field(default_factory=flags())
    """True if physics is simulated for the actor."""
    record: Records = field(default_factory=lambda: np.zeros(0, RECORD))
    """The actor's record in the snapshot."""

    def pose(self, row: int) -> Pose:
        """Return the pose of one actor."""
        return Pose(Vector(*self.position[row].tolist()), Rotation(*self.rotation[row].tolist()))

    def set_pose(self, row: int, pose: Pose) -> None:
        """Teleport one actor."""
        self.position[row] = pose.location
        self.rotation[row] = pose.rotation

    def publish(self) -> None:
        """Copy the motion of all actors into their records."""
        record = self.record
        record["location"] = self.position
        record["rotation"] = self.rotation
        record["velocity"] = self.velocity
        record["angular"] = self.angular
        record["acceleration"] = self.acceleration
