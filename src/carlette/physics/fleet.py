"""Vehicles: their controls, engines, tyres and steering, stepped together.

The model is a bicycle with a sliding body: the tyres pull the lateral velocity and the yaw rate towards those
of the steered path as hard as they can hold, so a car slides when it is hit or steered too fast.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from carlette.blueprints import VehicleModel
from carlette.geometry import Floats
from carlette.physics.bodies import Bodies
from carlette.world.table import Table, flags, indices, numbers

GRAVITY = 9.81
BRAKE_MPS2 = 8.5
HAND_BRAKE_MPS2 = 6.0
TYRE_GRIP_MPS2 = 9.0
ROLLING_MPS2 = 0.12
ENGINE_BRAKE_MPS2 = 0.5
ENGINE_BRAKE_PER_MPS = 0.03
HOLD_MPS2 = 3.0
"""Keeps a car at rest on a slope while nobody gives throttle, as a parked car is."""
HOLD_BELOW_MPS = 0.3
MAX_WHEEL_RAD = 1.5
STEER_RATE_PER_S = 4.0
DRIVE_LAG_S = 0.10
BRAKE_LAG_S = 0.08
BRAKING_SHARE = 0.3
"""Of the grip, always left for braking in a bend."""
YAW_LAG_S = 0.06
MAX_YAW_ACCELERATION = 20.0
TIGHTEST_RADIUS_M = 5.5
RADIUS_WHEELBASE_M = 2.88
STEER_SPEEDS_KMH = (0.0, 20.0, 60.0, 120.0)
STEER_FACTORS = (1.0, 0.9, 0.8, 0.7)
REVERSE_TOP_MPS = 12.0
GEAR_SPEEDS_MPS = np.array([6.0, 11.0, 17.0, 24.0])

THROTTLE, STEER, BRAKE, HAND_BRAKE, REVERSE, MANUAL, GEAR = range(7)


@dataclass
class Fleet(Table):
    """One row for each vehicle."""

    row: NDArray[np.int64] = field(default_factory=indices())
    """The vehicle's row in `Bodies`."""
    control: Floats = field(default_factory=numbers(7))
    """Throttle, steer, brake, hand brake, reverse, manual gear shift, gear: as the client sent them."""
    steer: Floats = field(default_factory=numbers())
    """Steering wheel, -1 to 1, after its rate limit."""
    drive: Floats = field(default_factory=numbers())
    """Throttle after the engine's lag."""
    pressure: Floats = field(default_factory=numbers())
    """Brake after its lag."""
    constant: Floats = field(default_factory=numbers(3))
    """Velocity held in the vehicle's frame, where `is_constant`."""
    is_constant: NDArray[np.bool_] = field(default_factory=flags())
    wheelbase: Floats = field(default_factory=numbers())
    power: Floats = field(default_factory=numbers())
    """Watts per kilogram at the wheels."""
    launch: Floats = field(default_factory=numbers())
    """Largest acceleration, m/s²."""
    drag: Floats = field(default_factory=numbers())
    """Deceleration by air for each (m/s)²."""
    max_steer: Floats = field(default_factory=numbers())
    """Wheel angle at full lock, radians."""
    light_state: NDArray[np.int64] = field(default_factory=indices())
    """Flags of `carla.VehicleLightState`."""

    def add(self, row: int, model: VehicleModel) -> int:
        """Adds a vehicle of `model` whose body is `row`."""
        power = 750.0 * model.power_kw / model.mass_kg
        top_mps = model.top_speed_kmh / 3.6
        return self.append(
            row=row,
            wheelbase=model.wheelbase_m,
            power=power,
            launch=min(5.5, 2.0 + 25.0 * model.power_kw / model.mass_kg),
            drag=power / top_mps**3,
            max_steer=np.radians(70.0),
            control=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
        )

    def clean_controls(self) -> Floats:
        """The controls with NaN as full (as Unreal's clamp has it) and all within their bounds."""
        control = np.where(np.isnan(self.control), 1.0, self.control)
        np.clip(control[:, :3], (0.0, -1.0, 0.0), 1.0, out=control[:, :3])
        return control

    def step(self, bodies: Bodies, dt: float) -> None:
        """Moves all simulated vehicles by `dt` seconds in the plane."""
        row = self.row
        active = bodies.simulated[row]
        control = self.clean_controls()
        yaw = np.radians(bodies.rotation[row, 1])
        cos, sin = np.cos(yaw), np.sin(yaw)
        world = bodies.velocity[row]
        ahead = world[:, 0] * cos + world[:, 1] * sin
        aside = world[:, 1] * cos - world[:, 0] * sin
        rate = np.radians(bodies.angular[row, 2])
        pitch = np.radians(bodies.rotation[row, 0])

        wanted = self._steered_rate(control, ahead, dt)
        side = np.minimum(np.abs(ahead) * np.maximum(np.abs(rate), np.abs(wanted)), TYRE_GRIP_MPS2)
        ahead = self._longitudinal(control, ahead, pitch, side, dt)
        rate, aside = self._lateral(wanted, ahead, aside, rate, dt)
        held = self.is_constant
        if held.any():
            ahead = np.where(held, self.constant[:, 0], ahead)
            aside = np.where(held, self.constant[:, 1], aside)
        ahead, aside, rate = (np.where(active, one, 0.0) for one in (ahead, aside, rate))

        yaw = yaw + rate * dt
        cos, sin = np.cos(yaw), np.sin(yaw)
        world[:, 0] = ahead * cos - aside * sin
        world[:, 1] = ahead * sin + aside * cos
        bodies.velocity[row, :2] = world[:, :2]
        bodies.position[row, :2] += world[:, :2] * dt
        bodies.rotation[row, 1] = np.where(active, (np.degrees(yaw) + 180.0) % 360.0 - 180.0, bodies.rotation[row, 1])
        bodies.angular[row, 2] = np.degrees(rate)
        self._publish(bodies, control, ahead)

    def _wheel_angle(self, ahead: Floats) -> Floats:
        """Angle of the front wheels in radians; less of it at speed, as CARLA's steering curve has it."""
        factor = np.interp(np.abs(ahead) * 3.6, STEER_SPEEDS_KMH, STEER_FACTORS)
        angle: Floats = np.clip(self.steer * self.max_steer * factor, -MAX_WHEEL_RAD, MAX_WHEEL_RAD)
        return angle

    def _longitudinal(self, control: Floats, ahead: Floats, pitch: Floats, side: Floats, dt: float) -> Floats:
        """Speed along the vehicle after `dt`: engine and slope push, friction only ever slows down.

        `side` is the lateral acceleration, which uses up grip.
        """
        grip = np.sqrt(np.maximum(TYRE_GRIP_MPS2**2 - side * side, (BRAKING_SHARE * TYRE_GRIP_MPS2) ** 2))
        throttle = control[:, THROTTLE]
        self.drive += (throttle - self.drive) * min(1.0, dt / DRIVE_LAG_S)
        self.drive[throttle == 0.0] = 0.0
        manual = control[:, MANUAL] > 0
        backward = np.where(manual, control[:, GEAR] < 0, control[:, REVERSE] > 0)
        neutral = manual & (control[:, GEAR] == 0)
        speed = np.abs(ahead)
        push = self.drive * np.minimum(self.launch, self.power / np.maximum(speed, 1.0))
        push[neutral | (backward & (ahead < -REVERSE_TOP_MPS))] = 0.0
        push = np.where(backward, -push, push) - GRAVITY * np.sin(pitch)
        resting = (throttle == 0.0) & (speed < HOLD_BELOW_MPS)
        coasting = (throttle == 0.0) * (ENGINE_BRAKE_MPS2 + ENGINE_BRAKE_PER_MPS * speed)
        self.pressure += (control[:, BRAKE] - self.pressure) * min(1.0, dt / BRAKE_LAG_S)
        friction = BRAKE_MPS2 * self.pressure + HAND_BRAKE_MPS2 * (control[:, HAND_BRAKE] > 0)
        friction = np.minimum(friction, grip) + ROLLING_MPS2 + coasting + HOLD_MPS2 * resting
        # The front wheels carry half of the side force and stand across the way.
        friction += self.drag * speed * speed + 0.5 * side * np.abs(np.sin(self._wheel_angle(ahead)))
        ahead = ahead + push * dt
        slowed: Floats = np.sign(ahead) * np.maximum(np.abs(ahead) - friction * dt, 0.0)
        return slowed

    def _steered_rate(self, control: Floats, ahead: Floats, dt: float) -> Floats:
        """Yaw rate (rad/s) of the path that the wheels point along, as far as the tyres hold it."""
        limit = STEER_RATE_PER_S * dt
        self.steer += np.clip(control[:, STEER] - self.steer, -limit, limit)
        sharpest = RADIUS_WHEELBASE_M / (TIGHTEST_RADIUS_M * self.wheelbase)
        curvature = sharpest * np.tanh(np.tan(self._wheel_angle(ahead)) / (self.wheelbase * sharpest))
        grip_rate = TYRE_GRIP_MPS2 / np.maximum(np.abs(ahead), 0.5)
        held: Floats = np.clip(ahead * curvature, -grip_rate, grip_rate)
        return held

    def _lateral(self, wanted: Floats, ahead: Floats, aside: Floats, rate: Floats, dt: float) -> tuple[Floats, Floats]:
        """Yaw rate (rad/s) and sideways speed after `dt`, on the way to those of the steered path."""
        change = (wanted - rate) * min(1.0, dt / YAW_LAG_S)
        rate = rate + np.clip(change, -MAX_YAW_ACCELERATION * dt, MAX_YAW_ACCELERATION * dt)
        slip = 0.5 * self.wheelbase * rate - aside
        turning = ahead * rate  # takes its share of the grip first
        aside = aside + np.clip(slip, (-TYRE_GRIP_MPS2 - turning) * dt, (TYRE_GRIP_MPS2 - turning) * dt)
        return rate, aside

    def steer_for(self, curvature: Floats, ahead: Floats) -> Floats:
        """The steer (-1 to 1) of all vehicles whose path has this curvature (1/m): the model turned round."""
        sharpest = RADIUS_WHEELBASE_M / (TIGHTEST_RADIUS_M * self.wheelbase)
        share = np.arctanh(np.clip(curvature / sharpest, -0.98, 0.98))
        factor = np.interp(np.abs(ahead) * 3.6, STEER_SPEEDS_KMH, STEER_FACTORS)
        angle = np.arctan(share * self.wheelbase * sharpest)
        steer: Floats = np.clip(angle / (self.max_steer * factor), -1.0, 1.0)
        return steer

    def pedals_for(self, acceleration: Floats, ahead: Floats) -> tuple[Floats, Floats]:
        """Throttle and brake of all vehicles for an acceleration (m/s²) on a level road."""
        drag = ROLLING_MPS2 + self.drag * ahead * ahead
        push = np.minimum(self.launch, self.power / np.maximum(ahead, 1.0))
        throttle = np.clip((acceleration + drag) / push, 0.0, 1.0)
        coasting = drag + ENGINE_BRAKE_MPS2 + ENGINE_BRAKE_PER_MPS * ahead
        brake = np.clip((-acceleration - coasting) / BRAKE_MPS2, 0.0, 1.0)
        return np.where(acceleration + drag > 0.0, throttle, 0.0), brake

    def _publish(self, bodies: Bodies, control: Floats, ahead: Floats) -> None:
        """Writes what the snapshot says of the controls."""
        record = bodies.record
        record["pedals"][self.row] = control[:, :3]
        record["switches"][self.row] = control[:, 3:6] > 0
        automatic = 1 + np.searchsorted(GEAR_SPEEDS_MPS, np.abs(ahead))
        automatic = np.where(control[:, REVERSE] > 0, -1, automatic)
        record["gear"][self.row] = np.where(control[:, MANUAL] > 0, control[:, GEAR], automatic)
