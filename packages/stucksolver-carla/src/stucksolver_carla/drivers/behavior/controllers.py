"""Steering and pedals: from a path and a wanted acceleration to the inputs of `carla.VehicleControl`.

Limits are those of `LocalPlanner` and `VehiclePIDController` (CARLA PythonAPI agents package, MIT): throttle 0.75,
steer 0.8, at most 0.1 of steer a tick, brake 0.5 except in emergencies. The published control laws swing out late at
low speed and jerk the pedals, so other laws are used here: curvature feed-forward with critically damped feedback of
the body's center for steering, and acceleration with a PI term for the pedals.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from stucksolver_carla.drivers.behavior.path import Path, Projection
from stucksolver_carla.drivers.behavior.steer_map import SteerMap
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

MAX_THROTTLE = 0.75
MAX_BRAKE = 0.5
MAX_STEER = 0.8
MAX_STEER_STEP = 0.1


class Pedals(NamedTuple):
    """Throttle and brake, each in [0, 1]."""

    throttle: float
    brake: float


class SteerController:
    """Keeps the body's center on a path and learns from the yaw rate how far the wheels really turn."""

    MIN_REACH_M = 1.8
    REACH_S = 0.5
    """The center returns to the path over about this much travel; the larger of the two counts."""
    MAX_APPROACH_RAD = 0.45
    _STEADY_STEP = 0.02

    def __init__(self, model: VehicleModel, steer: float = 0.0) -> None:
        self._model = model
        self._steer = steer
        self._last_step = 0.0
        self._map = SteerMap(model.wheel_lock)

    def observe(self, speed: float, yaw_rate: float) -> None:
        """Learn how far the wheels turn from the speed (m/s) and yaw rate (rad/s) after the last input."""
        if abs(self._last_step) < self._STEADY_STEP:
            self._map.observe(self._steer, speed, yaw_rate, self._model.wheelbase)

    def step(self, path: Path, where: Projection, speed: float, limit: float = MAX_STEER) -> float:
        """The steer input in [-limit, limit], right positive, for the body's center at `where` on `path`."""
        # No preview: the course already leads the heading by the slip of the present steering.
        course = where.heading + self._model.slip(self._map.angle(self._steer))
        curvature = self._wanted_curvature(path, where, course, speed)
        return self._turn_to(self._map.steer(self._model.steer_angle_for(curvature)), limit)

    def step_backwards(self, path: Path, where: Projection, speed: float, limit: float = MAX_STEER) -> float:
        """The same for the rear axle at `where`, its heading flipped, on a path driven backward.

        The rear axle leads then and moves where the body points; the center's slip would respond in the wrong
        direction.
        """
        curvature = self._wanted_curvature(path, where, where.heading, speed)
        return self._turn_to(self._map.steer(-math.atan(self._model.wheelbase * curvature)), limit)

    def straighten(self) -> float:
        """Return the steer input on the way to straight ahead, for a car that must first stop before it turns back."""
        return self._turn_to(0.0, MAX_STEER)

    def _wanted_curvature(self, path: Path, where: Projection, course: float, speed: float) -> float:
        reach = max(self.MIN_REACH_M, self.REACH_S * speed)
        approach = min(max(-where.lateral / (2.0 * reach), -self.MAX_APPROACH_RAD), self.MAX_APPROACH_RAD)
        return path.curvature_at(where.s) + 2.0 / reach * (approach - course)

    def _turn_to(self, wanted: float, limit: float) -> float:
        before = self._steer
        step = min(max(wanted - before, -MAX_STEER_STEP), MAX_STEER_STEP)
        self._steer = min(max(before + step, -limit), limit)
        self._last_step = self._steer - before
        return self._steer


class PedalController:
    """Tracks a wanted acceleration; a PI term on the resulting speed corrects the model's error."""

    FULL_THROTTLE_MPS2 = 5.5
    FULL_BRAKE_MPS2 = 9.0
    """Mean of a full stop from 15 m/s, which takes 12.7 m by the public fit of CARLA's Lincoln and on carlette.

    From 25 m/s it is 7.6, from 10 m/s 11.6; the PI term corrects that. Larger values stop later in an emergency.
    """
    EMERGENCY_MPS2 = 4.0
    """Decelerations above this may use the whole brake."""
    _GAIN_P = 0.35
    _GAIN_I = 0.25
    _MAX_LAG_MPS = 0.6
    _STANDSTILL_MPS = 0.08

    def __init__(self) -> None:
        self._reference = 0.0
        self._integral = 0.0

    def step(self, acceleration: float, speed: float, dt: float) -> Pedals:
        """Pedals for `acceleration` (m/s²) at `speed` (m/s), `dt` seconds after the last call."""
        if speed < self._STANDSTILL_MPS and acceleration <= 0.0:
            self._reference, self._integral = speed, 0.0
            return Pedals(0.0, MAX_BRAKE)
        moved = self._reference + acceleration * dt
        self._reference = min(max(moved, speed - self._MAX_LAG_MPS), speed + self._MAX_LAG_MPS)
        error = self._reference - speed
        self._integral = min(max(self._integral + error * dt, -1.0), 1.0)
        full = self.FULL_THROTTLE_MPS2 if acceleration > 0.0 else self.FULL_BRAKE_MPS2
        effort = acceleration / full + self._GAIN_P * error + self._GAIN_I * self._integral
        if effort >= 0.0:
            return Pedals(min(effort, MAX_THROTTLE), 0.0)
        most = 1.0 if acceleration < -self.EMERGENCY_MPS2 else MAX_BRAKE
        return Pedals(0.0, min(-effort, most))
