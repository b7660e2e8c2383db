"""Positions and rotations in CARLA's left-handed world: x ahead, y right, z up; meters and degrees.

Yaw is clockwise from above, so all planar formulas look as in a right-handed x-y plane.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


FARTHEST = 1e8
"""Bound on all numbers. No map, speed or force is larger; far beyond this, float32 and the carla library fail. Ours."""


class Vector(NamedTuple):
    """A location or direction in the world or in an actor's frame."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0

    def is_finite(self) -> bool:
        """False if a component is NaN, infinite or too large."""
        # NaN compares false with every number, so this form rejects it.
        return abs(self.x) < FARTHEST and abs(self.y) < FARTHEST and abs(self.z) < FARTHEST

    def plus(self, other: Vector) -> Vector:
        """Return the component-wise sum."""
        return Vector(self.x + other.x, self.y + other.y, self.z + other.z)


class Rotation(NamedTuple):
    """Pitch, yaw, roll in degrees (the order in which CARLA sends them)."""

    pitch: float = 0.0
    yaw: float = 0.0
    roll: float = 0.0


class Pose(NamedTuple):
    """Location and rotation of an object."""

    location: Vector = Vector()
    rotation: Rotation = Rotation()

    def is_finite(self) -> bool:
        """False if a number is NaN, infinite or too large."""
        return self.location.is_finite() and Vector(*self.rotation).is_finite()

    def apply(self, point: Vector) -> Vector:
        """Return `point` of this pose's frame in the outer frame."""
        return self.location.plus(rotate(point, self.rotation))

    def compose(self, child: Pose) -> Pose:
        """Return the pose of `child`, given in this frame, in the outer frame."""
        return Pose(self.apply(child.location), self._turn(child.rotation))

    def _turn(self, child: Rotation) -> Rotation:
        pitch, yaw, roll = self.rotation
        if pitch == 0.0 == roll:
            return Rotation(child.pitch, yaw + child.yaw, child.roll)
        ahead, right, up = (
            rotate(rotate(item, child), self.rotation) for item in (Vector(x=1.0), Vector(y=1.0), Vector(z=1.0))
        )
        return Rotation(
            math.degrees(math.atan2(ahead.z, math.hypot(ahead.x, ahead.y))),
            math.degrees(math.atan2(ahead.y, ahead.x)),
            math.degrees(math.atan2(-right.z, up.z)),
        )


class Box(NamedTuple):
    """A bounding box in an actor's frame: center, half sizes (m) and rotation."""

    center: Vector
    extent: Vector
    rotation: Rotation = Rotation()


def rotate(point: Vector, rotation: Rotation) -> Vector:
    """Return `point` rotated by CARLA's convention."""
    (cp, sp), (cy, sy), (cr, sr) = ((math.cos(math.radians(a)), math.sin(math.radians(a))) for a in rotation)
    x, y, z = point
    return Vector(
        x * cp * cy + y * (cy * sp * sr - sy * cr) + z * (-cy * sp * cr - sy * sr),
        x * cp * sy + y * (sy * sp * sr + cy * cr) + z * (-sy * sp * cr + cy * sr),
        x * sp - y * cp * sr + z * cp * cr,
    )


def turned(box: Box, rotation: Rotation) -> Box:
    """Return the upright box, in the frame rotated by the yaw only, around a box with pitch and roll."""
    tilt = Rotation(rotation.pitch, 0.0, rotation.roll)
    if tilt == Rotation():
        return box
    axes = [rotate(item, tilt) for item in (Vector(x=1.0), Vector(y=1.0), Vector(z=1.0))]
    half = [sum(abs(axis[i]) * size for axis, size in zip(axes, box.extent, strict=True)) for i in range(3)]
    return Box(rotate(box.center, tilt), Vector(*half))


def columns(first: Floats, second: Floats) -> Floats:
    """Return two columns side by side: `np.stack(..., axis=1)` in a third of its time, which matters in every tick."""
    both = np.empty((len(first), 2))
    both[:, 0], both[:, 1] = first, second
    return both


def bounded(value: Floats, low: Floats | float, high: Floats | float) -> Floats:
    """Return `np.clip` in a third of its time for short arrays."""
    held: Floats = np.minimum(np.maximum(value, low), high)
    return held


def wrap_degrees(angle: float) -> float:
    """Return the same angle within [-180, 180)."""
    return (angle + 180.0) % 360.0 - 180.0
