"""Selects detections that are near enough to be measured with their returns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import Detections

NEAR_M = 20.0
"""Maximum distance of a measured object (m). Farther away, rays are 0.2 m apart from one ring to the next, and too few
hit an end."""
STATIONARY_MPS = 1.0
"""Maximum speed of a measured object (m/s): the detector's error for stationary ones. A faster object is smeared by its
motion within a turn of the LiDAR."""


def stationary_nearby(detections: Detections, labels: Sequence[int]) -> NDArray[np.int64]:
    """Return the indices of stationary detections with one of these labels within `NEAR_M`."""
    distance = np.hypot(detections.center[:, 0], detections.center[:, 1])
    is_stationary = np.hypot(detections.velocity[:, 0], detections.velocity[:, 1]) < STATIONARY_MPS
    return np.flatnonzero(np.isin(detections.label, labels) & is_stationary & (distance < NEAR_M))
