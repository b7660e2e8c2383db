"""Vehicles: their controls, engines, tires and steering, stepped together.

The model is a bicycle model with a sliding body. The tires pull the lateral velocity and the yaw rate toward those of
the steered path within their grip, so a car slides when it is hit or steered too fast. It has no suspension and cannot
roll over.

The relation of throttle, speed and acceleration follows the public regression of the Lincoln MKZ 2020 in CARLA 0.9.15
(CARLA garage, PDM-Lite): the drive force grows with the square of the throttle, the engine's drag with the square of
the rest to full throttle. Other vehicles have the same curves, scaled by their own power and mass. Numbers without a
source are ours.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from carlette.blueprints import VehicleSpec
from carlette.geometry import Floats, bounded
from carlette.opendrive.speed_limit_boxes import UNSIGNED_KMH
from carlette.physics.bodies import BodyTable
from carlette.physics.column_table import Table, flags, indices, numbers
from carlette.physics.vehicle_parameters import (
    DAMPING_IDLE,
    DRAG_COEFFICIENT,
    FRICTION,
    HEAVY_KG,
    LAUNCH_MOST_MPS2,
    PhysicsParameters,
    Wheel,
    parameters_of,
)

GRAVITY = 9.81
BRAKE_MPS2 = 6.8
"""Deceleration at speed, with the engine's drag (m/s²)."""
HEAVY_BRAKE_MPS2 = 5.2
"""The same for heavy vehicles (m/s²)."""
BITE, BITE_MPS = 2.6, 6.0
"""Increase of the brakes' force at rest, as a share of it, and the speed up to which it decays (m/s).

Brakes hold harder at low speed.
"""
HAND_BRAKE_MPS2 = 6.0
"""Deceleration of the hand brake (m/s²)."""
TYRE_GRIP_MPS2 = 13.0
"""Lateral grip with the friction of CARLA's tires (m/s²). It scales with that friction."""
MOST_GRIP_MPS2 = 17.0
"""Largest lateral grip (m/s²)."""
LENGTHWISE_GRIP = 2.0
"""Longitudinal grip of the tires, as a multiple of the lateral one: enough for the brakes' force at low speed."""
ROLLING_MPS2 = 0.12
"""Rolling resistance (m/s²)."""
COAST_MPS2 = 3.9
"""Largest engine drag without throttle (m/s²), for a vehicle that launches with `LAUNCH_MOST_MPS2`."""
COAST_RISE_MPS = 2.5
"""Speed constant of the rise of engine drag from rest (m/s)."""
COAST_FALL_MPS = 18.0
"""Speed constant of the fall of engine drag at high speed (m/s)."""
NEUTRAL_COAST = 0.1
"""Share of the engine drag that remains in neutral."""
ENGAGE_S = 0.8
"""Time from the first throttle until the gearbox is in first gear (s). A vehicle is spawned in neutral.

The effect is known (CARLA issues #1640, #3256, #6477). The time is the median lead on the tuning half
of docs/real-carla.md.
"""
HOLD_MPS2 = 5.0
"""Deceleration that holds a vehicle at rest on a slope without pedal or steering input (m/s²).

Unreal puts such a vehicle to sleep.
"""
HOLD_BELOW_MPS = 0.1
"""Speed below which it applies (m/s)."""
MAX_WHEEL_RAD = 1.5
"""Largest wheel angle (rad)."""
STEER_RATE_PER_S = 4.0
"""Rate limit of the steering wheel (1/s)."""
BRAKING_SHARE = 0.3
"""Share of the grip that always remains for braking in a bend."""
YAW_LAG_S = 0.06
"""Time constant of the yaw rate (s)."""
MAX_YAW_ACCELERATION = 20.0
"""Largest yaw acceleration (rad/s²)."""
TIGHTEST_RADIUS_M = 3.7
"""Radius at full lock of a vehicle with the wheelbase below (m): the fit of World on Rails to CARLA's Lincoln."""
RADIUS_WHEELBASE_M = 2.88
"""Wheelbase of that vehicle (m)."""
SCRUB_SHARE = 0.25
"""Share of the tires' side force with which the steered front wheels slow the vehicle at full lock."""
STEER_KNOT_KMH = 20.0
"""Distance between the speeds of a steering curve (km/h)."""
STEER_KNOTS_KMH = STEER_KNOT_KMH * np.arange(10)
"""Speeds at which a vehicle's steering curve is stored (km/h)."""
SLIP_SHARE = 0.72
"""Curvature of the path as a share of that of the wheels' direction. CARLA's tires slip more than a bicycle model's."""
REVERSE_TOP_MPS = 12.0
"""Highest speed in reverse (m/s)."""
MOST_GEARS = 8
"""Maximum number of gears."""

NO_CONTROL = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
LEAST_CONTROL = np.array((0.0, -1.0, 0.0, -np.inf, -np.inf, -np.inf, -1.0))
MOST_CONTROL = np.array((1.0, 1.0, 1.0, np.inf, np.inf, np.inf, MOST_GEARS))
THROTTLE, STEER, BRAKE, HAND_BRAKE, REVERSE, MANUAL, GEAR = range(7)


@dataclass
class Vehicles(Table):
    """One row for each vehicle."""

    row: NDArray[np.int64] = field(default_factory=indices())
    """The vehicle's row in `BodyTable`."""
    control: Floats = field(default_factory=numbers(7))
    """Throttle, steer, brake, hand brake, reverse, manual gear shift, gear: as the client sent them."""
    steer: Floats = field(default_factory=numbers())
    """Steering wheel, -1 to 1, after its rate limit."""
    constant: Floats = field(default_factory=numbers(3))
    """Velocity held in the vehicle's frame, if `is_constant`."""
    is_constant: NDArray[np.bool_] = field(default_factory=flags())
    wheelbase: Floats = field(default_factory=numbers())
    power: Floats = field(default_factory=numbers())
    """Watts per kilogram at the wheels."""
    launch: Floats = field(default_factory=numbers())
    """Largest acceleration, m/s²."""
    drag: Floats = field(default_factory=numbers())
    """Deceleration by air drag per (m/s)² of squared speed."""
    coast: Floats = field(default_factory=numbers())
    """Largest engine drag without throttle, m/s²."""
    brake: Floats = field(default_factory=numbers())
    """Deceleration at full brake and speed, m/s²."""
    hand_brake: Floats = field(default_factory=numbers())
    grip: Floats = field(default_factory=numbers())
    """Largest acceleration that the tires hold, m/s²."""
    factors: Floats = field(default_factory=numbers(len(STEER_KNOTS_KMH)))
    """Share of the full wheel angle at each of `STEER_KNOTS_KMH`."""
    shift_mps: Floats = field(default_factory=numbers(MOST_GEARS))
    """Speed at which the automatic gearbox leaves each gear; infinity = never."""
    top_mps: Floats = field(default_factory=numbers(MOST_GEARS))
    """Speed at which the engine stops pushing in each gear."""
    ratio: Floats = field(default_factory=numbers(MOST_GEARS))
    """Drive force in each gear, as a share of that in first gear."""
    max_steer: Floats = field(default_factory=numbers())
    """Wheel angle at full lock, radians."""
    sticky: NDArray[np.bool_] = field(default_factory=flags())
    """True if it keeps its control until the next one, as CARLA's vehicles do by default."""
    light_state: NDArray[np.int64] = field(default_factory=indices())
    """Flags of `carla.VehicleLightState`."""
    engage_s: Floats = field(default_factory=numbers())
    """Time of throttle until the automatic gearbox is in gear for the first time (s)."""
    limit_kmh: Floats = field(default_factory=numbers())
    """Speed limit of the last sign that the vehicle passed (km/h)."""

    def add(self, row: int, model: VehicleSpec, physics: PhysicsParameters) -> int:
        """Add a vehicle of `model` whose body is `row`."""
        index = self.append(
            row=row,
            wheelbase=model.wheelbase_m,
            control=NO_CONTROL,
            sticky=True,
            engage_s=ENGAGE_S,
            limit_kmh=UNSIGNED_KMH,
        )
        self.take(index, model, physics)
        return index

    def take(self, index: int, model: VehicleSpec, physics: PhysicsParameters) -> None:
        """Set a vehicle's technical data. Values that it does not define stay as in the `model`."""
        mass, usual = physics.mass_kg, parameters_of(model)
        lighter = model.mass_kg / mass
        power = physics.power_w / mass
        launch = physics.launch_n / mass
        usual_launch = usual.launch_n / model.mass_kg
        full_brake = HEAVY_BRAKE_MPS2 if model.mass_kg > HEAVY_KG else BRAKE_MPS2
        friction = sum(wheel.friction for wheel in physics.wheels) / len(physics.wheels) / FRICTION
        top_mps = model.top_speed_kmh / 3.6
        gears = len(physics.gears)
        self.power[index], self.launch[index] = power, launch
        air = usual.power_w / model.mass_kg / top_mps**3
        self.drag[index] = air * lighter * physics.drag / DRAG_COEFFICIENT
        idle = physics.damping_idle / DAMPING_IDLE
        self.coast[index] = COAST_MPS2 * usual_launch / LAUNCH_MOST_MPS2 * idle * lighter
        self.brake[index] = full_brake * lighter * _share(physics, usual, lambda physic: physic.brake_nm)
        self.hand_brake[index] = HAND_BRAKE_MPS2 * lighter * _share(physics, usual, lambda physic: physic.hand_brake_nm)
        self.grip[index] = min(TYRE_GRIP_MPS2 * friction, MOST_GRIP_MPS2)
        self.max_steer[index] = np.radians(max(wheel.max_steer_deg for wheel in physics.wheels))
        speeds, factors = zip(*sorted(physics.steering_curve), strict=True)
        self.factors[index] = np.interp(STEER_KNOTS_KMH, speeds, factors)
        self.shift_mps[index] = np.inf
        shifts = [top * up for top, (_, _, up) in zip(physics.gear_tops(1.0), physics.gears, strict=True)]
        self.shift_mps[index, : gears - 1] = shifts[: gears - 1]
        self.top_mps[index, :gears] = physics.gear_tops(1.0)
        self.ratio[index, :gears] = [ratio / physics.gears[0][0] for ratio, _, _ in physics.gears]

    def clean_controls(self) -> Floats:
        """Return the controls within their bounds, with NaN as full input (as Unreal's clamp does)."""
        control = np.where(np.isnan(self.control), 1.0, self.control)
        return bounded(control, LEAST_CONTROL, MOST_CONTROL)

    def step(self, bodies: BodyTable, dt: float) -> None:
        """Move all simulated vehicles by `dt` seconds in the plane."""
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

        self._engage(control, active, dt)
        self._turn_wheel(control, dt)
        angle = self.wheel_angle(ahead)
        wanted = self._steered_rate(angle, ahead)
        side = np.minimum(np.abs(ahead) * np.maximum(np.abs(rate), np.abs(wanted)), self.grip)
        ahead = self._longitudinal(control, ahead, pitch, (side, angle), dt)
        rate, aside = self._lateral(wanted, ahead, aside, rate, dt)
        held = self.is_constant
        if held.any():
            ahead = np.where(held, self.constant[:, 0], ahead)
            aside = np.where(held, self.constant[:, 1], aside)
        ahead, aside, rate = (np.where(active, item, 0.0) for item in (ahead, aside, rate))

        yaw = yaw + rate * dt
        cos, sin = np.cos(yaw), np.sin(yaw)
        world[:, 0] = ahead * cos - aside * sin
        world[:, 1] = ahead * sin + aside * cos
        bodies.velocity[row, :2] = world[:, :2]
        bodies.position[row, :2] += world[:, :2] * dt
        bodies.rotation[row, 1] = np.where(active, (np.degrees(yaw) + 180.0) % 360.0 - 180.0, bodies.rotation[row, 1])
        bodies.angular[row, 2] = np.degrees(rate)
        self._publish(bodies, control, ahead)
        if not self.sticky.all():
            self.control[~self.sticky] = NO_CONTROL

    def _engage(self, control: Floats, active: NDArray[np.bool_], dt: float) -> None:
        """Put new vehicles into gear, as in CARLA: after a time with throttle, immediately by hand or in reverse."""
        chosen = (control[:, MANUAL] > 0) & (control[:, GEAR] != 0) | (control[:, REVERSE] > 0)
        pressed = active & (control[:, THROTTLE] > 0)
        self.engage_s = np.where(chosen, 0.0, np.maximum(self.engage_s - dt * pressed, 0.0))

    def wheel_angle(self, ahead: Floats) -> Floats:
        """Return the angle of the front wheels (rad). The vehicle's steering curve reduces it at speed."""
        angle: Floats = bounded(self.steer * self.max_steer * self._factor(ahead), -MAX_WHEEL_RAD, MAX_WHEEL_RAD)
        return angle

    def _factor(self, ahead: Floats) -> Floats:
        place = np.minimum(np.abs(ahead) * (3.6 / STEER_KNOT_KMH), len(STEER_KNOTS_KMH) - 1.001)
        knot = place.astype(np.int64)
        every = np.arange(len(self))
        low = self.factors[every, knot]
        factor: Floats = low + (place - knot) * (self.factors[every, knot + 1] - low)
        return factor

    def _full_push(self, speed: Floats) -> Floats:
        """Return the acceleration at full throttle (m/s²).

        It is limited by the launch at rest and by power at speed, with a smooth transition.
        """
        push: Floats = self.launch * self.power / np.hypot(self.launch * speed, self.power)
        return push

    def _idle_drag(self, speed: Floats) -> Floats:
        """Return the deceleration by the engine without throttle (m/s²)."""
        rise = 1.0 - np.exp(-speed / COAST_RISE_MPS)
        drag: Floats = self.coast * rise / (1.0 + (speed / COAST_FALL_MPS) ** 4)
        return drag

    def _full_brake(self, speed: Floats) -> Floats:
        """Return the deceleration at full brake (m/s²)."""
        brake: Floats = self.brake * (1.0 + BITE * np.exp(-((speed / BITE_MPS) ** 2)))
        return brake

    def _longitudinal(
        self, control: Floats, ahead: Floats, pitch: Floats, bend: tuple[Floats, Floats], dt: float
    ) -> Floats:
        """Return the speed along the vehicle after `dt`. Engine and slope push; friction can only slow it down.

        `bend` contains the lateral acceleration, which uses up grip, and the angle of the front wheels.
        """
        side, angle = bend
        most = LENGTHWISE_GRIP * self.grip
        grip = most * np.sqrt(np.maximum(1.0 - (side / self.grip) ** 2, BRAKING_SHARE**2))
        throttle, brake = control[:, THROTTLE], control[:, BRAKE]
        hand = control[:, HAND_BRAKE] > 0
        manual = control[:, MANUAL] > 0
        gear = control[:, GEAR]
        backward = np.where(manual, gear < 0, control[:, REVERSE] > 0)
        neutral = np.where(manual, gear == 0, self.engage_s > 1e-6)
        speed = np.abs(ahead)
        push = np.minimum(throttle**2 * self._full_push(speed), grip)
        if manual.any():
            push = push * np.where(manual, self._in_gear(gear, speed), 1.0)
        push[neutral | (backward & (ahead < -REVERSE_TOP_MPS))] = 0.0
        push = np.where(backward, -push, push) - GRAVITY * np.sin(pitch)
        untouched = (throttle == 0.0) & (control[:, STEER] == 0.0)
        idle = (1.0 - throttle) ** 2 * self._idle_drag(speed) * np.where(neutral, NEUTRAL_COAST, 1.0)
        slowing = brake * self._full_brake(speed) + (1.0 - brake) * idle + self.hand_brake * hand
        friction = np.minimum(slowing, grip) + ROLLING_MPS2
        friction += HOLD_MPS2 * (untouched & (speed < HOLD_BELOW_MPS))
        friction += self.drag * speed * speed + SCRUB_SHARE * side * np.abs(np.sin(angle))
        ahead = ahead + push * dt
        slowed: Floats = np.sign(ahead) * np.maximum(np.abs(ahead) - friction * dt, 0.0)
        return slowed

    def _in_gear(self, gear: Floats, speed: Floats) -> Floats:
        """Return the share of the automatic gearbox's drive force that a manually chosen gear provides."""
        place = bounded(np.abs(gear).astype(int) - 1, 0, MOST_GEARS - 1)
        every = np.arange(len(self))
        weaker = np.minimum(self.ratio[every, place] * self.launch / np.maximum(self._full_push(speed), 1e-6), 1.0)
        share: Floats = weaker * (speed < self.top_mps[every, place])
        return share

    def _turn_wheel(self, control: Floats, dt: float) -> None:
        limit = STEER_RATE_PER_S * dt
        self.steer += bounded(control[:, STEER] - self.steer, -limit, limit)

    def _steered_rate(self, angle: Floats, ahead: Floats) -> Floats:
        """Return the yaw rate (rad/s) of the path in the wheels' direction, within the tires' grip."""
        sharpest = RADIUS_WHEELBASE_M / (TIGHTEST_RADIUS_M * self.wheelbase)
        pointed = SLIP_SHARE * np.tan(angle) / (self.wheelbase * sharpest)
        curvature = sharpest * np.tanh(pointed)
        grip_rate = self.grip / np.maximum(np.abs(ahead), 0.5)
        held: Floats = bounded(ahead * curvature, -grip_rate, grip_rate)
        return held

    def _lateral(self, wanted: Floats, ahead: Floats, aside: Floats, rate: Floats, dt: float) -> tuple[Floats, Floats]:
        """Return yaw rate (rad/s) and lateral speed (m/s) after `dt`, moving toward those of the steered path."""
        change = (wanted - rate) * min(1.0, dt / YAW_LAG_S)
        rate = rate + bounded(change, -MAX_YAW_ACCELERATION * dt, MAX_YAW_ACCELERATION * dt)
        slip = 0.5 * self.wheelbase * rate - aside
        turning = ahead * rate  # it takes its share of the grip first
        aside = aside + bounded(slip, (-self.grip - turning) * dt, (self.grip - turning) * dt)
        return rate, aside

    def steer_for(self, curvature: Floats, ahead: Floats) -> Floats:
        """Return the steer (-1 to 1) for which each vehicle's path has this curvature (1/m): the inverse model."""
        sharpest = RADIUS_WHEELBASE_M / (TIGHTEST_RADIUS_M * self.wheelbase)
        share = np.arctanh(bounded(curvature / sharpest, -0.98, 0.98))
        angle = np.arctan(share * self.wheelbase * sharpest / SLIP_SHARE)
        steer: Floats = bounded(angle / (self.max_steer * self._factor(ahead)), -1.0, 1.0)
        return steer

    def pedals_for(self, acceleration: Floats, ahead: Floats) -> tuple[Floats, Floats]:
        """Return throttle and brake for which each vehicle has an acceleration (m/s²) on a level road."""
        speed = np.abs(ahead)
        full, idle = self._full_push(speed), self._idle_drag(speed)
        wanted = acceleration + ROLLING_MPS2 + self.drag * speed * speed
        # wanted = throttle² full - (1 - throttle)² idle, solved for the throttle.
        square = full - idle
        root = np.sqrt(np.maximum(idle * idle + square * (wanted + idle), 0.0))
        throttle = np.where(np.abs(square) > 1e-6, (root - idle) / np.where(square == 0.0, 1.0, square), 0.5)
        throttle = np.where(wanted > -idle, bounded(throttle, 0.0, 1.0), 0.0)
        brake = bounded((-wanted - idle) / np.maximum(self._full_brake(speed) - idle, 0.1), 0.0, 1.0)
        return throttle, brake

    def _publish(self, bodies: BodyTable, control: Floats, ahead: Floats) -> None:
        """Write the controls into the snapshot's records."""
        record = bodies.record
        record["pedals"][self.row] = control[:, :3]
        record["switches"][self.row] = control[:, 3:6] > 0
        automatic = 1 + (np.abs(ahead)[:, None] > self.shift_mps).sum(axis=1)
        automatic = np.where(control[:, REVERSE] > 0, -1, automatic)
        record["gear"][self.row] = np.where(control[:, MANUAL] > 0, control[:, GEAR], automatic)


def _share(physics: PhysicsParameters, usual: PhysicsParameters, of: Callable[[Wheel], float]) -> float:
    """Return the wheels' force under this physics, as a share of the usual one."""
    return sum(map(of, physics.wheels)) / max(sum(map(of, usual.wheels)), 1.0)
