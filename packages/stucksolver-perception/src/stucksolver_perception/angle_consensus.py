"""Decides from several measurements of an angle whether a sensor is miscalibrated."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

AGREEMENT_RAD = math.radians(0.5)
"""Maximum difference from the median of a measurement that agrees (rad). Ours."""
TURNED_RAD = math.radians(1.2)
"""Median angle above which a sensor counts as turned (rad). Healthy sensors have a measured median below 0.3 degrees.
Tires, crosswind and mounting tolerances may add 0.5 degrees on a real vehicle, and a margin of 0.5 degrees remains.
"""


class AngleConsensus:
    """The last measurements of an angle. A single one may have a large error, so nearly all of them must agree.

    Args:
        measurements: Number of measurements that are compared.
        agreeing: Number of them that must agree.
    """

    def __init__(self, measurements: int, agreeing: int) -> None:
        self._agreeing = agreeing
        self._angles: deque[float] = deque(maxlen=measurements)

    def add(self, angle_rad: float) -> None:
        """Add a measurement."""
        self._angles.append(angle_rad)

    @property
    def turned_rad(self) -> float | None:
        """Median angle (rad); None if it is small, or if too few measurements agree."""
        if len(self._angles) < (self._angles.maxlen or 0):
            return None
        angles = np.array(self._angles)
        median = float(np.median(angles))
        agreeing = int((np.abs(angles - median) < AGREEMENT_RAD).sum())
        return median if agreeing >= self._agreeing and abs(median) > TURNED_RAD else None
