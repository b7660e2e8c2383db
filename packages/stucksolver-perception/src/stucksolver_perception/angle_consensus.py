"""Decides from several measurements of an angle whether a sensor is turned."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

AGREE_RAD = math.radians(0.5)
"""Measurements agree if they differ from their median by no more than this."""
TURNED_RAD = math.radians(1.2)
"""A sensor counts as turned if the median is larger. Healthy ones were measured with a median of less than 0.3 degrees;
tires, crosswind and mounting tolerances may add half a degree on a real vehicle, and half a degree is left.
"""


class AngleConsensus:
    """The last measurements of an angle. A single one may be far off, so only what nearly all of them say counts.

    Args:
        measurements: How many are compared.
        agreeing: How many of them must agree.
    """

    def __init__(self, measurements: int, agreeing: int) -> None:
        self._agreeing = agreeing
        self._angles: deque[float] = deque(maxlen=measurements)

    def add(self, angle_rad: float) -> None:
        """Add a measurement."""
        self._angles.append(angle_rad)

    @property
    def turned_rad(self) -> float | None:
        """The angle (rad); None if it is small, or not known with certainty."""
        if len(self._angles) < (self._angles.maxlen or 0):
            return None
        angles = np.array(self._angles)
        median = float(np.median(angles))
        agreeing = int((np.abs(angles - median) < AGREE_RAD).sum())
        return median if agreeing >= self._agreeing and abs(median) > TURNED_RAD else None
