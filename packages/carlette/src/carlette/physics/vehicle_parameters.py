"""A vehicle's technical data in the terms of `carla.VehiclePhysicsControl`, and the values derived from them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from carlette.blueprints import VehicleSpec

Curve = tuple[tuple[float, float], ...]

EFFICIENCY = 0.68
"""Share of the engine's power at the wheels: with it the Lincoln MKZ accelerates as measured in CARLA 0.9.15."""
LAUNCH_BASE_MPS2 = 3.0
"""Launch acceleration of a vehicle without power (m/s²). Ours."""
LAUNCH_PER_KW_KG = 47.0
"""Launch acceleration per power and mass (m/s² per kW/kg). Ours."""
LAUNCH_MOST_MPS2 = 7.5
"""Largest launch acceleration (m/s²). Ours."""
HEAVY_KG = 3500.0
"""Mass above which a vehicle counts as heavy (kg). Ours."""
WHEEL_RADIUS_M = 0.35
"""Radius of the wheels (m). Ours."""
MAX_RPM = 6000.0
"""Highest engine speed (rpm). Ours."""
GEARS = (4.0, 2.5, 1.8, 1.3, 1.0)
"""Gear ratios. Ours."""
FINAL_RATIO = 4.0
"""Ratio of the differential. Ours."""
UP_RATIO = 0.65
"""Share of the highest engine speed at which the gearbox shifts up. Ours."""
STEERING_CURVE: Curve = ((0.0, 1.0), (20.0, 0.9), (60.0, 0.8), (120.0, 0.7))
"""Speed in km/h and the share of the full wheel angle; CARLA's default."""
FRICTION = 3.5
"""Friction of the tires. Ours."""
BRAKE_NM, HAND_BRAKE_NM = 1500.0, 3000.0
"""Torques of the brakes and of the hand brake (Nm). Ours."""
DAMPING_IDLE = 2.0
"""Damping of the engine with engaged clutch and closed throttle. Ours."""
DRAG_COEFFICIENT = 0.3
"""Drag coefficient. Ours."""


@dataclass(frozen=True)
class Wheel:
    """One wheel, in the order front left, front right, rear left, rear right."""

    friction: float = FRICTION
    damping: float = 0.25
    max_steer_deg: float = 70.0
    radius_cm: float = 100 * WHEEL_RADIUS_M
    brake_nm: float = BRAKE_NM
    hand_brake_nm: float = 0.0
    lateral_load: float = 3.0
    lateral_stiffness: float = 20.0
    longitudinal_stiffness: float = 3000.0


FRONT, REAR = Wheel(), Wheel(max_steer_deg=0.0, hand_brake_nm=HAND_BRAKE_NM)


@dataclass(frozen=True)
class PhysicsParameters:
    """The fields of `carla.VehiclePhysicsControl` in its order and units."""

    torque_curve: Curve
    """Engine speed in rpm and torque in Nm."""
    mass_kg: float
    max_rpm: float = MAX_RPM
    inertia: float = 1.0
    damping_full: float = 0.15
    damping_idle: float = DAMPING_IDLE
    damping_open: float = 0.35
    automatic: bool = True
    switch_s: float = 0.5
    clutch: float = 10.0
    final_ratio: float = FINAL_RATIO
    gears: tuple[tuple[float, float, float], ...] = tuple((ratio, 0.5, UP_RATIO) for ratio in GEARS)
    """Ratio, and the shares of the highest engine speed at which the gearbox shifts down and up."""
    drag: float = DRAG_COEFFICIENT
    center_of_mass: tuple[float, float, float] = (0.0, 0.0, 0.0)
    steering_curve: Curve = STEERING_CURVE
    wheels: tuple[Wheel, ...] = (FRONT, FRONT, REAR, REAR)
    sweeps_wheels: bool = True

    @property
    def radius_m(self) -> float:
        """Mean radius of the wheels (m)."""
        return sum(wheel.radius_cm for wheel in self.wheels) / len(self.wheels) / 100.0

    @property
    def launch_n(self) -> float:
        """Largest drive force in first gear (N)."""
        torque = max((nm for _, nm in self.torque_curve), default=0.0)
        ratio = self.gears[0][0] if self.gears else 1.0
        return EFFICIENCY * torque * ratio * self.final_ratio / self.radius_m

    @property
    def power_w(self) -> float:
        """Largest power at the wheels (W)."""
        limit = self.max_rpm
        peak = max((min(rpm, limit) * nm for rpm, nm in self.torque_curve), default=0.0)
        return EFFICIENCY * peak * math.tau / 60.0

    def gear_tops(self, share: float = UP_RATIO) -> tuple[float, ...]:
        """Return, for each gear, the speed (m/s) at which the engine turns at `share` of its highest speed."""
        turns = self.max_rpm / 60.0 * math.tau * self.radius_m
        return tuple(share * turns / max(ratio * self.final_ratio, 0.01) for ratio, _, _ in self.gears)


def parameters_of(model: VehicleSpec) -> PhysicsParameters:
    """Return the technical data of a kind of vehicle."""
    launch = min(LAUNCH_MOST_MPS2, LAUNCH_BASE_MPS2 + LAUNCH_PER_KW_KG * model.power_kw / model.mass_kg)
    torque = launch * model.mass_kg * WHEEL_RADIUS_M / (EFFICIENCY * GEARS[0] * FINAL_RATIO)
    base_rpm = min(1000.0 * model.power_kw / torque * 60.0 / math.tau, MAX_RPM)
    at_limit = 1000.0 * model.power_kw / MAX_RPM * 60.0 / math.tau
    curve = ((0.0, torque), (base_rpm, torque), (MAX_RPM, min(at_limit, torque)))
    wheels = (FRONT, REAR) if model.is_two_wheeler else (FRONT, FRONT) + (REAR,) * (model.wheels - 2)
    return PhysicsParameters(curve, model.mass_kg, wheels=wheels)
