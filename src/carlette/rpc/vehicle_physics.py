"""The physics of a vehicle as `carla.VehiclePhysicsControl` shows it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from carlette.blueprints import load_catalogue
from carlette.errors import RequestError
from carlette.geometry import Vector
from carlette.physics.sheet import Sheet, Wheel
from carlette.world.actor import Actor
from carlette.world.world import World

Wire = Sequence[Any]
TRACK_SHARE = 0.42
"""Half the track width, as a share of the vehicle's width."""
WHEEL_FIELDS = 9
"""Of a wheel, before its position."""
ABOVE_ZERO = ("mass_kg", "max_rpm", "final_ratio")


def physics_control(world: World, actor: Actor) -> list[Any]:
    """The 17 fields; wheel positions are in the world, in centimetres."""
    sheet = sheet_of_actor(actor)
    return [
        _points(sheet.torque_curve),
        sheet.max_rpm,
        sheet.inertia,
        sheet.damping_full,
        sheet.damping_idle,
        sheet.damping_open,
        sheet.automatic,
        sheet.switch_s,
        sheet.clutch,
        sheet.final_ratio,
        _points(sheet.gears),
        sheet.mass_kg,
        sheet.drag,
        list(sheet.center_of_mass),
        _points(sheet.steering_curve),
        [[*_wheel_fields(wheel), place] for wheel, place in zip(sheet.wheels, wheel_places(world, actor), strict=True)],
        sheet.sweeps_wheels,
    ]


def sheet_of_actor(actor: Actor) -> Sheet:
    """A vehicle's technical data; raises `RequestError` for anything else."""
    if actor.sheet is None:
        raise RequestError(f"actor {actor.id} ({actor.type_id}) is no vehicle and has no physics control")
    return actor.sheet


def wheel_places(world: World, actor: Actor) -> list[list[float]]:
    """The middle of each wheel in the world, in centimetres: front left, front right, rear left, rear right."""
    sheet = sheet_of_actor(actor)
    half_base = float(world.fleet.wheelbase[actor.index]) / 2
    half_track = actor.box.extent.y * 2 * TRACK_SHARE
    pose = world.pose(actor)
    if len(sheet.wheels) == 2:
        offsets = [(half_base, 0.0), (-half_base, 0.0)]
    else:
        rows = [half_base, *(-half_base - 1.3 * extra for extra in range(len(sheet.wheels) // 2 - 1))]
        offsets = [(along, side * half_track) for along in rows for side in (-1, 1)]
    return [[100 * one for one in pose.apply(Vector(along, across, sheet.radius_m))] for along, across in offsets]


def take_physics_control(world: World, actor: Actor, wire: Wire) -> None:
    """Takes over what a client wrote; the motion follows from the next tick on.

    Raises `RequestError` when a number is not finite or one that must be above zero is not.
    """
    wheels = tuple(Wheel(*map(float, one[:WHEEL_FIELDS])) for one in wire[15])
    old = sheet_of_actor(actor)
    sheet = replace(
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
        # Programs build a list of four wheels for every vehicle; the rest keeps what it had.
        wheels=(*wheels, *old.wheels[len(wheels) :])[: len(old.wheels)],
        sweeps_wheels=bool(wire[16]),
    )
    _check(sheet)
    actor.sheet = sheet
    world.bodies.mass[actor.row] = sheet.mass_kg
    world.fleet.take(actor.index, load_catalogue().vehicles[actor.type_id], sheet)


def _check(sheet: Sheet) -> None:
    for name in ABOVE_ZERO:
        value = getattr(sheet, name)
        if not (math.isfinite(value) and value > 0.0):
            raise RequestError(f"apply_physics_control: {name} is {value}; it must be a number above 0")
    for wheel in sheet.wheels:
        if not (0.0 <= wheel.max_steer_deg < 90.0 and wheel.radius_cm > 0.0 and wheel.friction >= 0.0):
            raise RequestError(
                f"apply_physics_control: a wheel with angle {wheel.max_steer_deg}° (0 to 90), radius {wheel.radius_cm} "
                f"cm (above 0) and friction {wheel.friction} (from 0) cannot be"
            )
    numbers = [one for curve in (sheet.torque_curve, sheet.steering_curve, sheet.gears) for row in curve for one in row]
    numbers += [sheet.drag, sheet.damping_idle, *(one for wheel in sheet.wheels for one in _wheel_fields(wheel))]
    if not all(math.isfinite(one) and abs(one) < 1e7 for one in numbers) or sheet.gears[0][0] == 0.0:
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
    return [list(one) for one in rows]


def _pairs(wire: Wire) -> tuple[tuple[float, float], ...]:
    return tuple((float(one[0]), float(one[1])) for one in wire)


def _gears(wire: Wire) -> tuple[tuple[float, float, float], ...]:
    return tuple((float(one[0]), float(one[1]), float(one[2])) for one in wire[:8])


def _triple(wire: Wire) -> tuple[float, float, float]:
    return (float(wire[0]), float(wire[1]), float(wire[2]))
