"""Steering and pedal control for vehicles of any kind."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import carla

_SLIP_SHARE = 0.72
"""Curvature of a car as a share of that of a bicycle model without slip: CARLA's cars turn wider.

Ours, from carlette.
"""
_WHEELBASE_PER_LENGTH = 0.6
"""Wheelbase as a share of the length, for vehicles without wheel positions. Ours."""


class BodyPedals:
    """Tracks a target acceleration with a PI controller on the resulting speed.

    Its gains also suit weak engines. Ours.
    """

    _FULL_THROTTLE_MPS2, _FULL_BRAKE_MPS2 = 5.5, 9.0
    """Acceleration at full throttle, and deceleration at full brake (m/s²), for the feedforward term."""
    _GAIN_P, _GAIN_I = 0.35, 0.3
    """Gains of the speed error (s/m) and of its integral (1/m)."""
    _MOST_LAG_MPS, _MOST_INTEGRAL_M = 1.0, 3.0
    """Largest lag of the target speed (m/s), and largest integral of the speed error (m). Both limit windup."""
    _STANDING_MPS = 0.08
    """Speed below which a braking vehicle counts as stopped (m/s)."""

    def __init__(self) -> None:
        self._reference_mps = 0.0
        self._integral_m = 0.0

    def step(self, acceleration: float, speed_mps: float, dt_s: float) -> tuple[float, float]:
        """Return throttle and brake, each in [0, 1], for a target acceleration (m/s²)."""
        if speed_mps < self._STANDING_MPS and acceleration <= 0.0:
            self._reference_mps, self._integral_m = speed_mps, 0.0
            return 0.0, 0.5
        wanted = self._reference_mps + acceleration * dt_s
        self._reference_mps = min(max(wanted, speed_mps - self._MOST_LAG_MPS), speed_mps + self._MOST_LAG_MPS)
        error = self._reference_mps - speed_mps
        if acceleration * self._integral_m < 0.0:
            self._integral_m *= 0.8  # an integral of the opposite sign would delay the response
        limit = self._MOST_INTEGRAL_M
        self._integral_m = min(max(self._integral_m + error * dt_s, -limit), limit)
        full = self._FULL_THROTTLE_MPS2 if acceleration > 0.0 else self._FULL_BRAKE_MPS2
        effort = acceleration / full + self._GAIN_P * error + self._GAIN_I * self._integral_m
        return (min(effort, 1.0), 0.0) if effort >= 0.0 else (0.0, min(-effort, 1.0))


@dataclass(frozen=True)
class Steering:
    """A vehicle's steering: wheelbase, largest wheel angle, and the share of it that CARLA allows at each speed."""

    wheelbase_m: float
    lock_rad: float
    curve_mps: tuple[float, ...]
    curve_share: tuple[float, ...]

    @staticmethod
    def from_vehicle(vehicle: carla.Vehicle, half_length_m: float) -> Steering:
        """Return the steering of a vehicle from its physics control. This queries the server."""
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
        """Return the steering input in [-1, 1] for a circle of this curvature (1/m, positive to the right)."""
        share = float(np.interp(speed_mps, self.curve_mps, self.curve_share))
        angle = math.atan(self.wheelbase_m * curvature / _SLIP_SHARE)
        return min(max(angle / (self.lock_rad * max(share, 0.1)), -1.0), 1.0)
