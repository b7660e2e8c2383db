"""Which detections stand close enough to be measured by their returns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import Detections

NEAR_M = 20.0
"""Farther away, rays are 0.2 m apart from one ring to the next, and too few hit an end."""
STANDS_MPS = 1.0
"""The detector measures the speed of what stands with this error. What is faster is smeared by its own motion within a
turn of the LiDAR.
"""


def standing_nearby(detections: Detections, labels: Sequence[int]) -> NDArray[np.int64]:
    """Return the indices of the detections with one of these labels that stand within `NEAR_M`."""
    away = np.hypot(detections.center[:, 0], detections.center[:, 1])
    stands = np.hypot(detections.velocity[:, 0], detections.velocity[:, 1]) < STANDS_MPS
    return np.flatnonzero(np.isin(detections.label, labels) & stands & (away < NEAR_M))
