"""How wrong a detection is expected to be, and how to write it in the local frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stucksolver.perception.measurements import Detections, Floats, PoseEstimate

POSITION_M = 0.15
"""Standard deviation of a near box's middle, in each axis."""
POSITION_PER_M = 0.003
"""What a metre of distance adds to it."""
LENGTH_SHARE = 0.03
"""A long body is seen in part: its middle is this share of the length wrong along its axis, where that is more."""
HEIGHT_M = 0.2
VELOCITY_MPS = 0.3
VELOCITY_PER_M = 0.004
YAW_RAD = 0.12
TIMING_S = 0.01
"""The sweep's time and the pose's may differ by this much: a moving or turning ego displaces what it sees."""


@dataclass(frozen=True, eq=False)
class Measured:
    """Detections in the local frame with their noise; equal lengths n."""

    time_s: float
    label: NDArray[np.int64]
    score: Floats
    z: Floats
    """(n, 6): x, y, z, yaw, vx, vy."""
    noise: Floats
    """(n, 6, 6): covariance of `z`."""
    size: Floats
    """(n, 3)."""
    range_m: Floats
    """(n,): distance from the ego."""

    def __len__(self) -> int:
        return len(self.label)


def measured(detections: Detections, pose: PoseEstimate) -> Measured:
    """Bring detections into the local frame.

    The covariance holds the detector's noise and what differs from look to look in the ego's pose (timing, speed). The
    pose's slow error is not in it: it displaces the ego and all that it sees alike, so that it cancels where tracks
    are used beside the pose that they were made with.
    """
    n = len(detections)
    cos, sin = np.cos(pose.yaw_rad), np.sin(pose.yaw_rad)
    turn = np.array([[cos, -sin], [sin, cos]])
    z = np.empty((n, 6))
    z[:, :2] = detections.center[:, :2] @ turn.T + (pose.x_m, pose.y_m)
    z[:, 2] = detections.center[:, 2] + pose.z_m
    z[:, 3] = detections.yaw + pose.yaw_rad
    z[:, 4:] = detections.velocity @ turn.T
    distance = np.hypot(detections.center[:, 0], detections.center[:, 1])
    noise = np.zeros((n, 6, 6))
    noise[:, :2, :2] = _position_noise(detections, pose, distance, z[:, 3])
    noise[:, 2, 2] = HEIGHT_M**2
    noise[:, 3, 3] = YAW_RAD**2
    velocity = VELOCITY_MPS + VELOCITY_PER_M * np.maximum(0.0, distance - 20.0)
    heading = np.array([cos, sin])
    noise[:, 4:, 4:] = velocity[:, None, None] ** 2 * np.eye(2) + pose.covariance[3, 3] * np.outer(heading, heading)
    return Measured(detections.time_s, detections.label, detections.score, z, noise, detections.size, distance)


def _position_noise(detections: Detections, pose: PoseEstimate, distance: Floats, yaw: Floats) -> Floats:
    """(n, 2, 2): wider along the body's axis than across, wider with distance and with the ego's motion."""
    across = POSITION_M + POSITION_PER_M * np.maximum(0.0, distance - 20.0)
    along = np.maximum(across, LENGTH_SHARE * detections.size[:, 0])
    ego = (TIMING_S * pose.speed_mps) ** 2 + (TIMING_S * pose.yaw_rate_rps * distance) ** 2
    cos, sin = np.cos(yaw), np.sin(yaw)
    axis = np.stack([cos, sin], axis=1)
    side = np.stack([-sin, cos], axis=1)
    covariance: Floats = (along**2)[:, None, None] * axis[:, :, None] * axis[:, None, :]
    covariance = covariance + (across**2)[:, None, None] * side[:, :, None] * side[:, None, :]
    return covariance + ego[:, None, None] * np.eye(2)
