"""Rotations between a sensor's frame and the world frame, both CARLA's: x ahead, y right, z up."""

from __future__ import annotations

import numpy as np

from carlette.geometry import Floats, Rotation, Vector, rotate


def axes(rotation: Rotation) -> Floats:
    """Return a 3x3 matrix that turns vectors of the rotated frame into the outer one.

    Its columns are the frame's axes.
    """
    columns: Floats = np.array([rotate(item, rotation) for item in (Vector(x=1.0), Vector(y=1.0), Vector(z=1.0))]).T
    return columns


def many_axes(rotations: Floats) -> Floats:
    """Return the matrices of many rotations, as in `axes`: (n, 3) pitch yaw roll (degrees) to (n, 3, 3)."""
    (cp, cy, cr), (sp, sy, sr) = np.cos(np.radians(rotations)).T, np.sin(np.radians(rotations)).T
    rows = [
        [cp * cy, cy * sp * sr - sy * cr, -cy * sp * cr - sy * sr],
        [cp * sy, sy * sp * sr + cy * cr, -sy * sp * cr + cy * sr],
        [sp, -cp * sr, cp * cr],
    ]
    matrices: Floats = np.moveaxis(np.array(rows), 2, 0)
    return matrices


def turn_between(before: Floats, after: Floats) -> Floats:
    """Return the rotation vector (rad, outer frame) that leads from one attitude, a 3x3 matrix, to another.

    Its sense is that of the cross product of components, as everywhere in CARLA: about z from x to y. A growing yaw
    therefore turns about +z, and a growing pitch or roll about -y or -x.
    """
    change = after @ before.T
    twice_sine = np.array([change[2, 1] - change[1, 2], change[0, 2] - change[2, 0], change[1, 0] - change[0, 1]])
    size = float(np.linalg.norm(twice_sine))
    angle = float(np.arctan2(size, np.trace(change) - 1.0))
    return twice_sine * (angle / size if size > 1e-12 else 0.5)
