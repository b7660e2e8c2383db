"""Describes the ego's body for the driver: size, wheelbase, and wheel lock."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import carla

_WHEELBASE_RANGE_M = (0.8, 8.0)
"""Bounds of a plausible wheelbase (m). Ours."""
_WHEELBASE_PER_LENGTH = 0.6
"""Wheelbase per length of a vehicle without plausible wheel positions. Ours."""
_DEFAULT_LOCK_DEG = 70.0
"""Wheel lock of a vehicle without wheels (degrees): the value of most cars in CARLA."""


@dataclass(frozen=True)
class VehicleModel:
    """A bicycle model with a box (m, rad)."""

    half_length: float
    half_width: float
    wheelbase: float
    wheel_lock: float
    """Angle of a front wheel at full steer input (rad)."""

    @property
    def rear_axle(self) -> float:
        """Distance of the rear axle behind the body's center (m)."""
        return self.wheelbase / 2.0

    def slip(self, steer_angle: float) -> float:
        """Return the angle between the motion of the body's center and the body's heading (rad)."""
        return math.atan(self.rear_axle / self.wheelbase * math.tan(steer_angle))

    def steer_angle_for(self, curvature: float) -> float:
        """Return the steering angle (rad) that moves the body's center on a circle of `curvature` (1/m)."""
        sine = min(max(self.rear_axle * curvature, -0.8), 0.8)
        return math.atan(self.wheelbase / self.rear_axle * math.tan(math.asin(sine)))


def vehicle_model(vehicle: carla.Vehicle) -> VehicleModel:
    """Return the model of a `carla.Vehicle` from its bounding box and physics control (two requests to the server)."""
    extent = vehicle.bounding_box.extent
    wheels = vehicle.get_physics_control().wheels
    lock = max((abs(wheel.max_steer_angle) for wheel in wheels), default=0.0) or _DEFAULT_LOCK_DEG
    return VehicleModel(
        half_length=float(extent.x),
        half_width=float(extent.y),
        wheelbase=_wheelbase(wheels, 2.0 * float(extent.x)),
        wheel_lock=math.radians(lock),
    )


def _wheelbase(wheels: Any, length: float) -> float:
    """Return the distance between front and rear wheel (m). CARLA's wheel positions, if set, are in cm."""
    if len(wheels) >= 4:
        front, rear = wheels[0].position, wheels[2].position
        base = math.dist((front.x, front.y, front.z), (rear.x, rear.y, rear.z)) / 100.0
        if _WHEELBASE_RANGE_M[0] < base < min(_WHEELBASE_RANGE_M[1], length):
            return base
    return _WHEELBASE_PER_LENGTH * length
