"""The physics of a vehicle as `carla.VehiclePhysicsControl` shows it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from carlette.errors import RequestError
from carlette.geometry import Vector
from carlette.physics.fleet import STEER_FACTORS, STEER_SPEEDS_KMH
from carlette.world.actor import Actor
from carlette.world.world import World

MASS, WHEELS = 11, 15
WHEEL_MAX_STEER = 2
TRACK_SHARE = 0.42
"""Half the track width, as a share of the vehicle's width."""
WHEEL_RADIUS_CM = 35.0


def physics_control(world: World, actor: Actor) -> list[Any]:
    """The 17 fields; wheel positions are in the world, in centimetres."""
    fleet = world.fleet
    power = float(fleet.power[actor.index] * world.bodies.mass[actor.row])
    torque = power / 400.0
    return [
        [[0.0, torque], [4000.0, torque], [6000.0, torque / 2]],
        6000.0,
        1.0,
        0.15,
        2.0,
        0.35,
        True,
        0.5,
        10.0,
        4.0,
        [[ratio, 0.5, 0.65] for ratio in (4.0, 2.5, 1.8, 1.3, 1.0)],
        float(world.bodies.mass[actor.row]),
        0.3,
        [0.0, 0.0, 0.0],
        [list(pair) for pair in zip(STEER_SPEEDS_KMH, STEER_FACTORS, strict=True)],
        _wheels(world, actor),
        True,
    ]


def _wheels(world: World, actor: Actor) -> list[Any]:
    half_base = float(world.fleet.wheelbase[actor.index]) / 2
    half_track = actor.box.extent.y * 2 * TRACK_SHARE
    steer_deg = math.degrees(world.fleet.max_steer[actor.index])
    pose = world.pose(actor)
    wheels = []
    for along, across in ((1, -1), (1, 1), (-1, -1), (-1, 1)):
        place = pose.apply(Vector(along * half_base, across * half_track, WHEEL_RADIUS_CM / 100))
        position = [100 * one for one in place]
        front = along > 0
        wheels.append(
            [
                3.5,
                0.25,
                steer_deg if front else 0.0,
                WHEEL_RADIUS_CM,
                1500.0,
                0.0 if front else 3000.0,
                3.0,
                20.0,
                3000.0,
                position,
            ]
        )
    return wheels


def take_physics_control(world: World, actor: Actor, wire: Sequence[Any]) -> None:
    """Takes over mass and largest wheel angle; the rest of the drive train stays the model's own.

    Raises `RequestError` when either is not a number above zero.
    """
    mass_kg = float(wire[MASS])
    steer_deg = max((float(wheel[WHEEL_MAX_STEER]) for wheel in wire[WHEELS]), default=70.0)
    if not (math.isfinite(mass_kg) and mass_kg > 0 and 0 < steer_deg < 90):
        raise RequestError(f"apply_physics_control: mass {mass_kg} kg and wheel angle {steer_deg}° must be above 0")
    world.bodies.mass[actor.row] = mass_kg
    world.fleet.max_steer[actor.index] = math.radians(steer_deg)
