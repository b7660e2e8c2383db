"""Computes the inputs of `carla.VehicleControl` from a path and a target acceleration.

Limits are those of `LocalPlanner` and `VehiclePIDController` (CARLA PythonAPI agents package, MIT): throttle 0.75,
steer 0.8, at most 0.1 of steer per tick, brake 0.5 except in emergencies. The published control laws react late at low
speed and cause jerk, so other laws are used here: curvature feed-forward with critically damped feedback of the body's
center for steering, and acceleration with a PI term for the pedals.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from stucksolver_carla.drivers.behavior.path import Path, Projection
from stucksolver_carla.drivers.behavior.steer_map import SteerMap
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

MAX_THROTTLE = 0.75
"""Maximum throttle input (CARLA agents)."""
MAX_BRAKE = 0.5
"""Maximum brake input outside emergencies (CARLA agents)."""
MAX_STEER = 0.8
"""Maximum steer input (CARLA agents)."""
MAX_STEER_STEP = 0.1
"""Maximum change of the steer input per tick (CARLA agents)."""


class Pedals(NamedTuple):
    """Throttle and brake, each in [0, 1]."""

    throttle: float
    brake: float


class SteerController:
    """Keeps the body's center on a path, and learns the effect of the steer input from the yaw rate."""

    MIN_REACH_M = 1.8
    """Minimum travel over which the center returns to the path (m). Ours."""
    REACH_S = 0.5
    """Time over which the center returns to the path, if that is more than `MIN_REACH_M` of travel (s). Ours."""
    MAX_APPROACH_RAD = 0.45
    """Maximum angle between path and course while the center returns to the path (rad). Ours."""
    _STEADY_STEP = 0.02
    """Change of the steer input per tick below which the input counts as steady. Ours."""

    def __init__(self, model: VehicleModel, steer: float = 0.0) -> None:
        self._model = model
        self._steer = steer
        self._last_step = 0.0
        self._map = SteerMap(model.wheel_lock)

    def observe(self, speed: float, yaw_rate: float) -> None:
        """Learn the wheels' steering angle from the speed (m/s) and yaw rate (rad/s) after the last input."""
        if abs(self._last_step) < self._STEADY_STEP:
            self._map.observe(self._steer, speed, yaw_rate, self._model.wheelbase)

    def step(self, path: Path, where: Projection, speed: float, limit: float = MAX_STEER) -> float:
        """Return the steer input in [-limit, limit], right positive, for the body's center at `where` on `path`."""
        # No preview is needed, because the course already leads the heading by the slip of the present steering.
        course = where.heading + self._model.slip(self._map.angle(self._steer))
        curvature = self._wanted_curvature(path, where, course, speed)
        return self._set_steer(self._map.steer(self._model.steer_angle_for(curvature)), limit)

    def step_backwards(self, path: Path, where: Projection, speed: float, limit: float = MAX_STEER) -> float:
        """Return the steer input for a path that is driven backward.

        `where` is the projection of the rear axle with flipped heading. The rear axle leads when backing up, and moves
        in the body's direction. The center's slip would respond in the wrong direction.
        """
        curvature = self._wanted_curvature(path, where, where.heading, speed)
        return self._set_steer(self._map.steer(-math.atan(self._model.wheelbase * curvature)), limit)

    def straighten(self) -> float:
        """Return the steer input toward straight ahead, for a car that must stop before it changes its direction."""
        return self._set_steer(0.0, MAX_STEER)

    def _wanted_curvature(self, path: Path, where: Projection, course: float, speed: float) -> float:
        reach = max(self.MIN_REACH_M, self.REACH_S * speed)
        approach = min(max(-where.lateral / (2.0 * reach), -self.MAX_APPROACH_RAD), self.MAX_APPROACH_RAD)
        return path.curvature_at(where.s) + 2.0 / reach * (approach - course)

    def _set_steer(self, target: float, limit: float) -> float:
        last_steer = self._steer
        step = min(max(target - last_steer, -MAX_STEER_STEP), MAX_STEER_STEP)
        self._steer = min(max(last_steer + step, -limit), limit)
        self._last_step = self._steer - last_steer
        return self._steer


class PedalController:
    """Tracks a target acceleration. A PI term on the resulting speed corrects the model's error."""

    FULL_THROTTLE_MPS2 = 5.5
    """Assumed acceleration at full throttle (m/s²). Ours; the PI term corrects it."""
    FULL_BRAKE_MPS2 = 9.0
    """Assumed deceleration at full brake (m/s²): the mean of a full stop from 15 m/s.

    Such a stop takes 12.7 m by the public fit of CARLA's Lincoln and on carlette. From 25 m/s the mean is 7.6, from
    10 m/s 11.6; the PI term corrects that. With larger values, emergency stops are longer.
    """
    EMERGENCY_MPS2 = 4.0
    """Deceleration above which the whole brake may be used (m/s²). Ours."""
    _GAIN_P = 0.35
    """Pedal input per speed error (s/m). Ours."""
    _GAIN_I = 0.25
    """Pedal input per integrated speed error (1/m). Ours."""
    _MAX_LAG_MPS = 0.6
    """Maximum difference between the reference speed and the speed (m/s). Ours."""
    _STANDSTILL_MPS = 0.08
    """Speed below which the brake holds the ego (m/s). Ours."""

    def __init__(self) -> None:
        self._reference = 0.0
        self._integral = 0.0

    def step(self, acceleration: float, speed: float, dt: float) -> Pedals:
        """Return the pedals for `acceleration` (m/s²) at `speed` (m/s), `dt` seconds after the last call."""
        if speed < self._STANDSTILL_MPS and acceleration <= 0.0:
            self._reference, self._integral = speed, 0.0
            return Pedals(0.0, MAX_BRAKE)
        reference = self._reference + acceleration * dt
        self._reference = min(max(reference, speed - self._MAX_LAG_MPS), speed + self._MAX_LAG_MPS)
        error = self._reference - speed
        self._integral = min(max(self._integral + error * dt, -1.0), 1.0)
        full = self.FULL_THROTTLE_MPS2 if acceleration > 0.0 else self.FULL_BRAKE_MPS2
        effort = acceleration / full + self._GAIN_P * error + self._GAIN_I * self._integral
        if effort >= 0.0:
            return Pedals(min(effort, MAX_THROTTLE), 0.0)
        max_brake = 1.0 if acceleration < -self.EMERGENCY_MPS2 else MAX_BRAKE
        return Pedals(0.0, min(-effort, max_brake))
