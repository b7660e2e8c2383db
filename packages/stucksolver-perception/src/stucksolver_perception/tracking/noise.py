"""Converts detections to the local frame, with their expected errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import Detections, Floats, PoseEstimate

ALONG_M = np.array([0.15, 0.20, 0.10, 0.12, 0.20, 0.06, 0.10, 0.10])
"""(labels,): standard deviation of a box's center within `NEAR_M`, along the object's axis (m).

It is the change of the error within a second. A constant error shifts all positions of an object alike, and does not
look like motion. From cycle to cycle the error changes by a third to a half of this. All numbers in this file, and
those of `track_management.py`, are those that `python -m lab perception eval --only noise` prints, rounded up, for
drives in Town02 and Town10HD, where the detector was not trained, and for three routes of held-out scenario types.
"""
ACROSS_M = np.array([0.10, 0.12, 0.08, 0.12, 0.10, 0.06, 0.10, 0.08])
"""(labels,): standard deviation of the center across that axis (m)."""
NEAR_M = 10.0
"""Distance up to which the errors are constant (m)."""
FARTHER_SHARE = 0.04
"""Relative increase of both per meter beyond `NEAR_M`: they double at 35 m."""
HEIGHT_M = 0.2
"""Standard deviation of the center's height (m)."""
VELOCITY_ALONG_MPS = np.array([1.0, 1.0, 2.5, 1.8, 2.2, 1.0, 1.0, 1.0])
"""(labels,): standard deviation of the velocity within `NEAR_M`, along the object's axis (m/s)."""
VELOCITY_ACROSS_MPS = np.array([0.6, 0.6, 1.2, 1.8, 2.2, 1.0, 1.0, 1.0])
"""(labels,): standard deviation of the velocity across that axis (m/s)."""
VELOCITY_FARTHER_SHARE = 0.4
"""Relative increase of the standard deviation along the axis per meter beyond `NEAR_M`. For a car at 15 m/s the
detector measures most of the speed at 10 m, 3 m/s less at 25 m, and hardly any of it at 45 m. The error across the axis
is constant."""
VELOCITY_CORRELATED = 10.0
"""Number of detections with as much information as one, because the velocity's error is constant for a second."""
YAW_RAD = 0.15
"""Standard deviation of the yaw (rad)."""
YAW_CORRELATED = 20.0
"""Number of detections with as much information as one on the yaw, because an object's visible sides change slowly."""
TIMING_S = 0.01
"""Possible difference between the times of sweep and pose (s). It shifts detections if the ego moves or turns."""


@dataclass(frozen=True, eq=False)
class NoisyDetections:
    """Detections in the local frame with their noise; equal lengths n."""

    time_s: float
    label: NDArray[np.int64]
    """(n,): index into `LABELS`."""
    score: Floats
    """(n,): score."""
    z: Floats
    """(n, 6): x, y, z, yaw, vx, vy."""
    noise: Floats
    """(n, 6, 6): covariance of `z`."""
    size: Floats
    """(n, 3): length, width, height (m)."""
    height_known: NDArray[np.bool_]
    """(n,): see `Detections`."""
    range_m: Floats
    """(n,): distance from the ego (m)."""

    def __len__(self) -> int:
        return len(self.label)


def with_noise(detections: Detections, pose: PoseEstimate) -> NoisyDetections:
    """Return detections in the local frame, with their noise.

    The covariance contains the detector's noise and the errors of the ego's pose that change quickly (timing, speed).
    It does not contain the pose's slow error. That error shifts the ego and all objects alike, so that it cancels when
    tracks are used together with the pose from which they were computed.
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
    heading = np.array([cos, sin])
    factor = 1.0 + VELOCITY_FARTHER_SHARE * np.maximum(0.0, distance - NEAR_M)
    along = VELOCITY_ALONG_MPS[detections.label] * factor
    # The error of the yaw rotates the axis. Twice its standard deviation is used.
    across = np.hypot(VELOCITY_ACROSS_MPS[detections.label], 2.0 * YAW_RAD * along)
    noise[:, 4:, 4:] = _along_and_across(along, across, z[:, 3])
    noise[:, 4:, 4:] += pose.covariance[3, 3] * np.outer(heading, heading)
    height_known = np.zeros(n, np.bool_) if detections.height_known is None else detections.height_known
    return NoisyDetections(
        detections.time_s, detections.label, detections.score, z, noise, detections.size, height_known, distance
    )


def _position_noise(detections: Detections, pose: PoseEstimate, distance: Floats, yaw: Floats) -> Floats:
    """Return (n, 2, 2): covariances of the positions, which increase with distance and with the ego's motion (m²)."""
    factor = 1.0 + FARTHER_SHARE * np.maximum(0.0, distance - NEAR_M)
    along, across = ALONG_M[detections.label] * factor, ACROSS_M[detections.label] * factor
    ego = (TIMING_S * pose.speed_mps) ** 2 + (TIMING_S * pose.yaw_rate_rps * distance) ** 2
    return _along_and_across(along, across, yaw) + ego[:, None, None] * np.eye(2)


def _along_and_across(along: Floats, across: Floats, yaw: Floats) -> Floats:
    """Return (n, 2, 2): covariances with these standard deviations along and across an axis."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    axis = np.stack([cos, sin], axis=1)
    side = np.stack([-sin, cos], axis=1)
    covariance: Floats = (along**2)[:, None, None] * axis[:, :, None] * axis[:, None, :]
    covariance = covariance + (across**2)[:, None, None] * side[:, :, None] * side[:, None, :]
    return covariance
