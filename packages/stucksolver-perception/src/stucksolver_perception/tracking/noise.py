"""The expected errors of a detection, and its conversion to the local frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import Detections, Floats, PoseEstimate

ALONG_M = np.array([0.15, 0.20, 0.10, 0.12, 0.20, 0.06, 0.10, 0.10])
"""(labels,): standard deviation of the middle of a box within `NEAR_M`, along the body's axis.

It is how much the error changes within a second. A constant error displaces an object and its past alike, and does not
look like motion. From look to look the error changes a third to a half as much. All numbers in this file, and those of
`existence.py`, are those that `python -m lab perception eval --only noise` prints, rounded up, for drives in Town02 and
Town10HD, where the detector was not trained, and for three routes of held-out scenario types.
"""
ACROSS_M = np.array([0.10, 0.12, 0.08, 0.12, 0.10, 0.06, 0.10, 0.08])
"""(labels,): the same across that axis."""
NEAR_M = 10.0
FARTHER = 0.04
"""Share of both that each meter beyond `NEAR_M` adds: they double at 35 m."""
HEIGHT_M = 0.2
VELOCITY_ALONG_MPS = np.array([1.0, 1.0, 2.5, 1.8, 2.2, 1.0, 1.0, 1.0])
"""(labels,): standard deviation of the velocity within `NEAR_M`, along the body's axis."""
VELOCITY_ACROSS_MPS = np.array([0.6, 0.6, 1.2, 1.8, 2.2, 1.0, 1.0, 1.0])
"""(labels,): the same across that axis."""
VELOCITY_FARTHER = 0.4
"""Share of the first that each meter beyond `NEAR_M` adds. Of a car at 15 m/s the detector measures most at 10 m, 3 m/s
less at 25 m, and hardly anything at 45 m. Across the axis its error stays the same.
"""
VELOCITY_LOOKS = 10.0
"""Number of looks that carry no more information than one: the velocity's error stays the same for a second."""
YAW_RAD = 0.15
YAW_LOOKS = 20.0
"""The same for the yaw: the sides of a body that are seen change slowly."""
TIMING_S = 0.01
"""Possible difference between the times of sweep and pose (s): a moving or turning ego displaces what it sees."""


@dataclass(frozen=True, eq=False)
class NoisyDetections:
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
    height_known: NDArray[np.bool_]
    """(n,), see `Detections`."""
    range_m: Floats
    """(n,): distance from the ego (m)."""

    def __len__(self) -> int:
        return len(self.label)


def measured(detections: Detections, pose: PoseEstimate) -> NoisyDetections:
    """Return detections converted to the local frame.

    The covariance holds the detector's noise and the errors of the ego's pose that differ by look (timing, speed).
    The pose's slow error is left out: it displaces the ego and everything that it sees alike, so it cancels when tracks
    are used together with the pose from which they were computed.
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
    farther = 1.0 + VELOCITY_FARTHER * np.maximum(0.0, distance - NEAR_M)
    along = VELOCITY_ALONG_MPS[detections.label] * farther
    # The axis is only known as well as the yaw, of which twice the usual error is allowed for.
    across = np.hypot(VELOCITY_ACROSS_MPS[detections.label], 2.0 * YAW_RAD * along)
    noise[:, 4:, 4:] = _along_and_across(along, across, z[:, 3])
    noise[:, 4:, 4:] += pose.covariance[3, 3] * np.outer(heading, heading)
    known = np.zeros(n, np.bool_) if detections.height_known is None else detections.height_known
    return NoisyDetections(
        detections.time_s, detections.label, detections.score, z, noise, detections.size, known, distance
    )


def _position_noise(detections: Detections, pose: PoseEstimate, distance: Floats, yaw: Floats) -> Floats:
    """(n, 2, 2): wider along the body's axis than across, wider with distance and with the ego's motion."""
    farther = 1.0 + FARTHER * np.maximum(0.0, distance - NEAR_M)
    along, across = ALONG_M[detections.label] * farther, ACROSS_M[detections.label] * farther
    ego = (TIMING_S * pose.speed_mps) ** 2 + (TIMING_S * pose.yaw_rate_rps * distance) ** 2
    return _along_and_across(along, across, yaw) + ego[:, None, None] * np.eye(2)


def _along_and_across(along: Floats, across: Floats, yaw: Floats) -> Floats:
    """(n, 2, 2): covariances with these standard deviations along and across an axis."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    axis = np.stack([cos, sin], axis=1)
    side = np.stack([-sin, cos], axis=1)
    covariance: Floats = (along**2)[:, None, None] * axis[:, :, None] * axis[:, None, :]
    covariance = covariance + (across**2)[:, None, None] * side[:, :, None] * side[:, None, :]
    return covariance
