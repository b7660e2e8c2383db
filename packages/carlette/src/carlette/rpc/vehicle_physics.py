"""The physics of a vehicle as `carla.VehiclePhysicsControl` shows it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from carlette.blueprints import load_catalog
from carlette.errors import RequestError
from carlette.geometry import Vector
from carlette.physics.vehicle_parameters import PhysicsParameters, Wheel
from carlette.world.actor import Actor
from carlette.world.world import World

Wire = Sequence[Any]
TRACK_SHARE = 0.42
"""Half the track width, as a share of the vehicle's width. Ours."""
WHEEL_FIELDS = 9
"""Number of a wheel's fields before its position."""
ABOVE_ZERO = ("mass_kg", "max_rpm", "final_ratio")


def physics_control(world: World, actor: Actor) -> list[Any]:
    """Return the 17 fields. Wheel positions are in the world frame (cm)."""
    physics = parameters_of_actor(actor)
    return [
        _points(physics.torque_curve),
        physics.max_rpm,
        physics.inertia,
        physics.damping_full,
        physics.damping_idle,
        physics.damping_open,
        physics.automatic,
        physics.switch_s,
        physics.clutch,
        physics.final_ratio,
        _points(physics.gears),
        physics.mass_kg,
        physics.drag,
        list(physics.center_of_mass),
        _points(physics.steering_curve),
        [
            [*_wheel_fields(wheel), place]
            for wheel, place in zip(physics.wheels, wheel_places(world, actor), strict=True)
        ],
        physics.sweeps_wheels,
    ]


def parameters_of_actor(actor: Actor) -> PhysicsParameters:
    """Return a vehicle's technical data; raise `RequestError` for anything else."""
    if actor.physics is None:
        raise RequestError(f"actor {actor.id} ({actor.type_id}) is not a vehicle and has no physics control")
    return actor.physics


def wheel_places(world: World, actor: Actor) -> list[list[float]]:
    """Return the centers of the wheels in the world frame (cm): front left, front right, rear left, rear right."""
    physics = parameters_of_actor(actor)
    half_base = float(world.fleet.wheelbase[actor.index]) / 2
    half_track = actor.box.extent.y * 2 * TRACK_SHARE
    pose = world.pose(actor)
    if len(physics.wheels) == 2:
        offsets = [(half_base, 0.0), (-half_base, 0.0)]
    else:
        rows = [half_base, *(-half_base - 1.3 * extra for extra in range(len(physics.wheels) // 2 - 1))]
        offsets = [(along, side * half_track) for along in rows for side in (-1, 1)]
    return [[100 * item for item in pose.apply(Vector(along, across, physics.radius_m))] for along, across in offsets]


def take_physics_control(world: World, actor: Actor, wire: Wire) -> None:
    """Set the values that a client sent. The motion uses them from the next tick on.

    Raises:
        RequestError: A number is not finite, or one that must be above zero is not.
    """
    wheels = tuple(Wheel(*map(float, item[:WHEEL_FIELDS])) for item in wire[15])
    old = parameters_of_actor(actor)
    physics = replace(
        old,
        torque_curve=_pairs(wire[0]) or old.torque_curve,
        max_rpm=float(wire[1]),
        inertia=float(wire[2]),
        damping_full=float(wire[3]),
        damping_idle=float(wire[4]),
        damping_open=float(wire[5]),
        automatic=bool(wire[6]),
        switch_s=float(wire[7]),
        clutch=float(wire[8]),
        final_ratio=float(wire[9]),
        gears=_gears(wire[10]) or old.gears,
        mass_kg=float(wire[11]),
        drag=float(wire[12]),
        center_of_mass=_triple(wire[13]),
        steering_curve=_pairs(wire[14]) or old.steering_curve,
        # Programs send four wheels for every vehicle. Other wheels keep their values.
        wheels=(*wheels, *old.wheels[len(wheels) :])[: len(old.wheels)],
        sweeps_wheels=bool(wire[16]),
    )
    _check(physics)
    actor.physics = physics
    world.bodies.mass[actor.row] = physics.mass_kg
    world.fleet.take(actor.index, load_catalog().vehicles[actor.type_id], physics)


def _check(physics: PhysicsParameters) -> None:
    for name in ABOVE_ZERO:
        value = getattr(physics, name)
        if not (math.isfinite(value) and value > 0.0):
            raise RequestError(f"apply_physics_control: {name} is {value}; it must be a number above 0")
    for wheel in physics.wheels:
        if not (0.0 <= wheel.max_steer_deg < 90.0 and wheel.radius_cm > 0.0 and wheel.friction >= 0.0):
            raise RequestError(
                f"apply_physics_control: a wheel with angle {wheel.max_steer_deg}° (0 to 90), radius {wheel.radius_cm} "
                f"cm (above 0) and friction {wheel.friction} (from 0) cannot be"
            )
    numbers = [
        item for curve in (physics.torque_curve, physics.steering_curve, physics.gears) for row in curve for item in row
    ]
    numbers += [
        physics.drag,
        physics.damping_idle,
        *(field for wheel in physics.wheels for field in _wheel_fields(wheel)),
    ]
    if not all(math.isfinite(number) and abs(number) < 1e7 for number in numbers) or physics.gears[0][0] == 0.0:
        raise RequestError("apply_physics_control: a number is not finite or the first gear's ratio is 0")


def _wheel_fields(wheel: Wheel) -> list[float]:
    return [
        wheel.friction,
        wheel.damping,
        wheel.max_steer_deg,
        wheel.radius_cm,
        wheel.brake_nm,
        wheel.hand_brake_nm,
        wheel.lateral_load,
        wheel.lateral_stiffness,
        wheel.longitudinal_stiffness,
    ]


def _points(rows: Iterable[tuple[float, ...]]) -> list[list[float]]:
    return [list(row) for row in rows]


def _pairs(wire: Wire) -> tuple[tuple[float, float], ...]:
    return tuple((float(item[0]), float(item[1])) for item in wire)


def _gears(wire: Wire) -> tuple[tuple[float, float, float], ...]:
    return tuple((float(item[0]), float(item[1]), float(item[2])) for item in wire[:8])


def _triple(wire: Wire) -> tuple[float, float, float]:
    return (float(wire[0]), float(wire[1]), float(wire[2]))
