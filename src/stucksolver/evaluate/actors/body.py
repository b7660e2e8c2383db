"""How a kind of vehicle steers: enough to follow a line, from its physics control."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

_SLIP_SHARE = 0.72
"""Of the path that the wheels point along: CARLA's cars drive wider than a bicycle model without slip."""
_WHEELBASE_PER_LENGTH = 0.6


@dataclass(frozen=True)
class Steering:
    """Lengths in metres, angles in radians, speeds in m/s."""

    wheelbase_m: float
    lock_rad: float
    curve_mps: tuple[float, ...]
    curve_share: tuple[float, ...]

    @staticmethod
    def of(vehicle: Any, half_length_m: float) -> Steering:
        """Asks the server for a `carla.Vehicle`'s physics control."""
        physics = vehicle.get_physics_control()
        lock_deg = max((abs(wheel.max_steer_angle) for wheel in physics.wheels), default=70.0) or 70.0
        curve = sorted((point.x / 3.6, point.y) for point in physics.steering_curve) or [(0.0, 1.0)]
        return Steering(
            2.0 * half_length_m * _WHEELBASE_PER_LENGTH,
            math.radians(lock_deg),
            tuple(x for x, _ in curve),
            tuple(y for _, y in curve),
        )

    def steer(self, curvature: float, speed_mps: float) -> float:
        """The input in [-1, 1] that drives a circle of this curvature (1/m, right positive)."""
        share = float(np.interp(speed_mps, self.curve_mps, self.curve_share))
        angle = math.atan(self.wheelbase_m * curvature / _SLIP_SHARE)
        return min(max(angle / (self.lock_rad * max(share, 0.1)), -1.0), 1.0)
