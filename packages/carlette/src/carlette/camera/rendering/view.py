"""Pose and image of a camera: projection and frustum.

Camera frame: x ahead, y right, z up. Pixel (u, v): u to the right, v down, the first pixel's center at (0.5, 0.5). The
image plane is CARLA's: focal length width / (2 tan(fov / 2)) in both directions, no distortion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from carlette.camera.arrays import Singles
from carlette.geometry import Floats, Pose, Rotation

NEAR_M = 0.1
"""Distance of the near plane (m). Ours."""
FAR_M = 1000.0
"""Distance of the far plane (m): the range of CARLA's depth camera."""


@dataclass(frozen=True)
class CameraView:
    """One camera at one time."""

    pose: Pose
    width: int
    height: int
    fov_deg: float

    @property
    def tangents(self) -> tuple[float, float]:
        """Half the picture's width and height at a distance of one meter."""
        across = math.tan(math.radians(self.fov_deg) / 2)
        return across, across * self.height / self.width

    def axes(self) -> Floats:
        """Return rows: the camera's x, y and z axis in the world."""
        return axes_of(self.pose.rotation)

    def into_camera(self) -> Singles:
        """4x4 matrix from the world to the camera's frame."""
        matrix = np.eye(4)
        axes = self.axes()
        matrix[:3, :3] = axes
        matrix[:3, 3] = -axes @ np.array(self.pose.location)
        into: Singles = matrix.astype(np.float32)
        return into

    def pixels(self, points: Floats) -> Floats:
        """Return u, v and distance ahead (m) of world points (n, 3), (n, 3).

        They are meaningful where the distance is positive.
        """
        local = (points - np.array(self.pose.location)) @ self.axes().T
        across, up = self.tangents
        ahead = np.where(np.abs(local[:, 0]) < 1e-9, 1e-9, local[:, 0])
        u = (local[:, 1] / ahead / across + 1.0) * self.width / 2
        v = (1.0 - local[:, 2] / ahead / up) * self.height / 2
        return np.stack([u, v, local[:, 0]], axis=1)

    def sees(self, centers: Floats, radii: Floats, reach_m: float) -> NDArray[np.bool_]:
        """Return which spheres may be in the picture and within `reach_m`."""
        local = (centers - np.array(self.pose.location)) @ self.axes().T
        across, up = self.tangents
        inside: NDArray[np.bool_] = (local[:, 0] > -radii) & (np.linalg.norm(local, axis=1) - radii < reach_m)
        for tangent, column in ((across, 1), (up, 2)):
            beyond = np.abs(local[:, column]) - local[:, 0] * tangent
            inside &= beyond < radii * math.hypot(1.0, tangent)
        return inside


def axes_of(rotation: Rotation) -> Floats:
    """Return rows: the x, y and z axis of a frame with CARLA's rotation (as `carlette.geometry.rotate` has it)."""
    (cp, sp), (cy, sy), (cr, sr) = ((math.cos(math.radians(a)), math.sin(math.radians(a))) for a in rotation)
    return np.array(
        (
            (cp * cy, cp * sy, sp),
            (cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, -cp * sr),
            (-cy * sp * cr - sy * sr, -sy * sp * cr + cy * sr, cp * cr),
        )
    )


def matrix_of(pose: Pose) -> Floats:
    """4x4, from the frame of `pose` to the world."""
    matrix = np.zeros((4, 4))
    matrix[3, 3] = 1.0
    matrix[:3, :3] = axes_of(pose.rotation).T
    matrix[:3, 3] = pose.location
    return matrix
