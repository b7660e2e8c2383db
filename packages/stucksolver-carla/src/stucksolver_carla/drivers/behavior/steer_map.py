"""How far the wheels turn for a steer input: CARLA's inputs are shares of a lock of unknown effect."""

from __future__ import annotations

import math

import numpy as np

_KNOTS = np.array([0.05, 0.25, 0.6])
_FIRST_SHARES = np.array([0.9, 0.8, 0.6])
"""Steering angle of the equivalent bicycle over input times wheel lock: a wheel that turns far slides outward."""
_LEARNING_RATE = 0.04
_PLAUSIBLE = (0.3, 1.3)
_MIN_SPEED_MPS = 1.5
_MIN_STEER = 0.02


class SteerMap:
    """Steering angle (rad) of the equivalent bicycle for each steer input in [-1, 1], learned while driving."""

    def __init__(self, wheel_lock: float) -> None:
        self._wheel_lock = wheel_lock
        self._shares = _FIRST_SHARES.copy()

    def angle(self, steer: float) -> float:
        """The angle that the input `steer` leads to."""
        return steer * self._wheel_lock * self._share(steer)

    def steer(self, angle: float) -> float:
        """Return the input that leads to `angle`; it may exceed 1 if no input does."""
        steer = angle / self._wheel_lock
        for _ in range(4):
            steer = angle / (self._wheel_lock * self._share(steer))
        return steer

    def observe(self, steer: float, speed: float, yaw_rate: float, wheelbase: float) -> None:
        """Learn from the yaw rate (rad/s) that a steady input led to at `speed` (m/s)."""
        if speed < _MIN_SPEED_MPS or abs(steer) < _MIN_STEER:
            return
        share = math.atan(yaw_rate * wheelbase / speed) / (steer * self._wheel_lock)
        if _PLAUSIBLE[0] < share < _PLAUSIBLE[1]:
            # Each knot stands for the inputs near it.
            weights = np.array([np.interp(abs(steer), _KNOTS, unit) for unit in np.eye(len(_KNOTS))])
            self._shares += _LEARNING_RATE * weights * (share - self._share(steer))

    def _share(self, steer: float) -> float:
        return float(np.interp(abs(steer), _KNOTS, self._shares))
