"""Maps steer inputs to steering angles. CARLA's inputs are shares of a wheel lock whose effect is unknown."""

from __future__ import annotations

import math

import numpy as np

_KNOTS = np.array([0.05, 0.25, 0.6])
"""Steer inputs of the map's knots. Ours."""
_FIRST_SHARES = np.array([0.9, 0.8, 0.6])
"""First guess at each knot: steering angle of the equivalent bicycle, divided by input times wheel lock. The share
falls with the input, because a wheel at a large angle slides outward. Ours."""
_LEARNING_RATE = 0.04
"""Share of an observed error by which the map changes. Ours."""
_PLAUSIBLE = (0.3, 1.3)
"""Bounds of a plausible observed share; others are dropped. Ours."""
_MIN_SPEED_MPS = 1.5
"""Minimum speed of an observation (m/s). Ours."""
_MIN_STEER = 0.02
"""Minimum steer input of an observation. Ours."""


class SteerMap:
    """Steering angle (rad) of the equivalent bicycle for each steer input in [-1, 1], learned while driving."""

    def __init__(self, wheel_lock: float) -> None:
        self._wheel_lock = wheel_lock
        self._shares = _FIRST_SHARES.copy()

    def angle(self, steer: float) -> float:
        """Return the steering angle for the input `steer` (rad)."""
        return steer * self._wheel_lock * self._share(steer)

    def steer(self, angle: float) -> float:
        """Return the input for the steering angle `angle` (rad); it exceeds 1 if no input reaches the angle."""
        steer = angle / self._wheel_lock
        for _ in range(4):
            steer = angle / (self._wheel_lock * self._share(steer))
        return steer

    def observe(self, steer: float, speed: float, yaw_rate: float, wheelbase: float) -> None:
        """Learn from the yaw rate (rad/s) of a steady input at `speed` (m/s)."""
        if speed < _MIN_SPEED_MPS or abs(steer) < _MIN_STEER:
            return
        share = math.atan(yaw_rate * wheelbase / speed) / (steer * self._wheel_lock)
        if _PLAUSIBLE[0] < share < _PLAUSIBLE[1]:
            # Each knot changes by its interpolation weight for this input.
            weights = np.array([np.interp(abs(steer), _KNOTS, unit) for unit in np.eye(len(_KNOTS))])
            self._shares += _LEARNING_RATE * weights * (share - self._share(steer))

    def _share(self, steer: float) -> float:
        return float(np.interp(abs(steer), _KNOTS, self._shares))
