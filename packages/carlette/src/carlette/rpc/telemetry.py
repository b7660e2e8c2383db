"""A vehicle's telemetry (`carla.VehicleTelemetryData`, client 0.9.16)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from carlette.physics.vehicle_dynamics import BRAKE, GRAVITY, STEER, THROTTLE
from carlette.physics.vehicle_parameters import EFFICIENCY
from carlette.rpc.vehicle_physics import parameters_of_actor
from carlette.world.actor import Actor
from carlette.world.world import World

IDLE_RPM = 800.0
"""Engine speed at rest (rpm). Ours."""


def wheel_angle(world: World, actor: Actor) -> float:
    """Return the angle of the front wheels (rad)."""
    return float(world.fleet.wheel_angle(_speeds(world))[actor.index])


def telemetry(world: World, actor: Actor) -> list[Any]:
    """Return speed (m/s), steer, throttle, brake, engine speed (rpm), gear, drag (N) and 11 numbers for each wheel.

    The numbers of a wheel are friction, lateral and longitudinal slip (both 0: wheels do not slip separately here),
    turning speed (rad/s), tire load (N), the load as a share of its static one, longitudinal and lateral force (N), the
    two forces as shares of the load, and torque (Nm).
    """
    fleet, index = world.fleet, actor.index
    physics = parameters_of_actor(actor)
    control = fleet.clean_controls()[index]
    gear = int(world.bodies.record["gear"][actor.row])
    speed = float(_speeds(world)[index])
    ratio = physics.gears[min(max(abs(gear), 1), len(physics.gears)) - 1][0] * physics.final_ratio
    turning = speed / physics.radius_m
    rpm = min(max(abs(turning) * ratio * 60.0 / math.tau, IDLE_RPM), physics.max_rpm)
    drag = float(fleet.drag[index]) * physics.mass_kg * speed * speed
    speeds_rpm, torques = zip(*physics.torque_curve, strict=True)
    nm = float(np.interp(rpm, speeds_rpm, torques)) * float(fleet.control[index, THROTTLE])
    wheels = [_wheel(world, actor, wheel.friction, turning, EFFICIENCY * nm * ratio) for wheel in physics.wheels]
    pedals = [float(control[STEER]), float(control[THROTTLE]), float(control[BRAKE])]
    return [speed, *pedals, rpm, gear, drag, wheels]


def _wheel(world: World, actor: Actor, friction: float, turning: float, torque: float) -> list[float]:
    physics = parameters_of_actor(actor)
    count = len(physics.wheels)
    load = physics.mass_kg * GRAVITY / count
    yaw = math.radians(world.bodies.rotation[actor.row, 1])
    east, south, _ = world.bodies.acceleration[actor.row].tolist()
    along = physics.mass_kg / count * (east * math.cos(yaw) + south * math.sin(yaw))
    across = physics.mass_kg / count * (south * math.cos(yaw) - east * math.sin(yaw))
    return [friction, 0.0, 0.0, turning, load, 1.0, along, across, along / load, across / load, torque / count]


def _speeds(world: World) -> Any:
    bodies, row = world.bodies, world.fleet.row
    yaw = np.radians(bodies.rotation[row, 1])
    return bodies.velocity[row, 0] * np.cos(yaw) + bodies.velocity[row, 1] * np.sin(yaw)
