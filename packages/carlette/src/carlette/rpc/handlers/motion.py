"""Poses, velocities, forces and physics switches of any actor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from carlette.errors import RequestError
from carlette.geometry import Pose, Vector
from carlette.rpc.registry import Methods
from carlette.rpc.session import ClientSession
from carlette.wire import encode
from carlette.world.actor import Actor, ActorKind

methods = Methods()

Wire = Sequence[Any]


def finite(wire: Wire, method: str) -> Vector:
    """Return a vector of a request; raise `RequestError` if it is not finite. NaN never enters the world."""
    vector = encode.read_vector(wire)
    if not vector.is_finite():
        raise RequestError(f"{method}: the vector {tuple(vector)} is not finite; give real numbers")
    return vector


@methods.void("set_actor_transform")
def set_actor_transform(session: ClientSession, actor_id: int, transform: Wire) -> None:
    actor = session.actor(actor_id, "set_actor_transform")
    pose = encode.read_pose(transform)
    if not pose.is_finite():
        raise RequestError("set_actor_transform: the transform is not finite; give real coordinates")
    session.world.teleport(actor, pose)


@methods.void("set_actor_location")
def set_actor_location(session: ClientSession, actor_id: int, location: Wire) -> None:
    actor = session.actor(actor_id, "set_actor_location")
    place = finite(location, "set_actor_location")
    session.world.teleport(actor, Pose(place, session.world.pose(actor).rotation))


@methods.void("set_actor_target_velocity")
def set_actor_target_velocity(session: ClientSession, actor_id: int, velocity: Wire) -> None:
    actor = session.actor(actor_id, "set_actor_target_velocity")
    vector = finite(velocity, "set_actor_target_velocity")
    if session.world.bodies.simulated[actor.row]:
        session.world.bodies.velocity[actor.row] = vector
        _let_walk_on(session)


@methods.void("set_actor_target_angular_velocity")
def set_actor_target_angular_velocity(session: ClientSession, actor_id: int, velocity: Wire) -> None:
    actor = session.actor(actor_id, "set_actor_target_angular_velocity")
    vector = finite(velocity, "set_actor_target_angular_velocity")
    if session.world.bodies.simulated[actor.row]:
        session.world.bodies.angular[actor.row] = vector


@methods.void("enable_actor_constant_velocity")
def enable_actor_constant_velocity(session: ClientSession, actor_id: int, velocity: Wire) -> None:
    actor = session.vehicle(actor_id, "enable_actor_constant_velocity")
    session.world.fleet.constant[actor.index] = finite(velocity, "enable_actor_constant_velocity")
    session.world.fleet.is_constant[actor.index] = True


@methods.void("disable_actor_constant_velocity")
def disable_actor_constant_velocity(session: ClientSession, actor_id: int) -> None:
    actor = session.vehicle(actor_id, "disable_actor_constant_velocity")
    session.world.fleet.is_constant[actor.index] = False


@methods.void("add_actor_impulse")
def add_actor_impulse(session: ClientSession, actor_id: int, impulse: Wire) -> None:
    actor = session.actor(actor_id, "add_actor_impulse")
    kick(session, actor, finite(impulse, "add_actor_impulse"))


@methods.void("add_actor_impulse_at_location")
def add_actor_impulse_at_location(session: ClientSession, actor_id: int, impulse: Wire, location: Wire) -> None:
    actor = session.actor(actor_id, "add_actor_impulse_at_location")
    vector = finite(impulse, "add_actor_impulse_at_location")
    place = finite(location, "add_actor_impulse_at_location")
    kick(session, actor, vector)
    spin(session, actor, _moment(session, actor, vector, place))


@methods.void("add_actor_force")
def add_actor_force(session: ClientSession, actor_id: int, force: Wire) -> None:
    actor = session.actor(actor_id, "add_actor_force")
    kick(session, actor, _over_step(session, finite(force, "add_actor_force")))


@methods.void("add_actor_force_at_location")
def add_actor_force_at_location(session: ClientSession, actor_id: int, force: Wire, location: Wire) -> None:
    actor = session.actor(actor_id, "add_actor_force_at_location")
    impulse = _over_step(session, finite(force, "add_actor_force_at_location"))
    kick(session, actor, impulse)
    spin(session, actor, _moment(session, actor, impulse, finite(location, "add_actor_force_at_location")))


@methods.void("add_actor_angular_impulse")
def add_actor_angular_impulse(session: ClientSession, actor_id: int, impulse: Wire) -> None:
    actor = session.actor(actor_id, "add_actor_angular_impulse")
    spin(session, actor, finite(impulse, "add_actor_angular_impulse").z)


@methods.void("add_actor_torque")
def add_actor_torque(session: ClientSession, actor_id: int, torque: Wire) -> None:
    actor = session.actor(actor_id, "add_actor_torque")
    spin(session, actor, _over_step(session, finite(torque, "add_actor_torque")).z)


def kick(session: ClientSession, actor: Actor, impulse: Vector) -> None:
    """Change an actor's velocity by an impulse (N·s, world frame)."""
    bodies = session.world.bodies
    mass = float(bodies.mass[actor.row])
    if mass > 0 and bodies.simulated[actor.row]:
        bodies.velocity[actor.row] += np.array(impulse) / mass
        _let_walk_on(session)


def spin(session: ClientSession, actor: Actor, moment: float) -> None:
    """Change an actor's yaw rate by an angular impulse about z (N·m·s)."""
    bodies = session.world.bodies
    mass = float(bodies.mass[actor.row])
    if mass > 0 and bodies.simulated[actor.row]:
        inertia = mass * (actor.box.extent.x**2 + actor.box.extent.y**2) / 3.0
        bodies.angular[actor.row, 2] += math.degrees(moment / inertia)


def _let_walk_on(session: ClientSession) -> None:
    """Let the motion of a walker that was not commanded decay, whatever its cause."""
    if len(session.world.walkers):
        session.world.walkers.take_push(session.world.bodies)


def _over_step(session: ClientSession, force: Vector) -> Vector:
    dt = session.world.step_s
    return Vector(force.x * dt, force.y * dt, force.z * dt)


def _moment(session: ClientSession, actor: Actor, impulse: Vector, place: Vector) -> float:
    center = session.world.pose(actor).location
    return (place.x - center.x) * impulse.y - (place.y - center.y) * impulse.x


@methods.void("set_actor_simulate_physics")
def set_actor_simulate_physics(session: ClientSession, actor_id: int, enabled: bool) -> None:
    actor = session.actor(actor_id, "set_actor_simulate_physics")
    bodies = session.world.bodies
    bodies.simulated[actor.row] = enabled and bodies.mass[actor.row] > 0
    if not enabled:
        bodies.velocity[actor.row] = 0.0
        bodies.angular[actor.row] = 0.0


@methods.void("set_actor_collisions")
def set_actor_collisions(session: ClientSession, actor_id: int, enabled: bool) -> None:
    actor = session.actor(actor_id, "set_actor_collisions")
    session.world.bodies.solid[actor.row] = enabled and actor.touches


@methods.void("set_actor_enable_gravity")
def set_actor_enable_gravity(session: ClientSession, actor_id: int, enabled: bool) -> None:
    actor = session.actor(actor_id, "set_actor_enable_gravity")
    if actor.surface >= 0:
        session.world.surface.weightless[actor.surface] = not enabled


@methods.void("set_actor_dead")
def set_actor_dead(session: ClientSession, actor_id: int) -> None:
    """Let a walker fall and lie, or stop a vehicle with its hand brake."""
    actor = session.actor(actor_id, "set_actor_dead")
    world = session.world
    if actor.kind is ActorKind.WALKER:
        world.walkers.dead[actor.index] = True
    elif actor.kind is ActorKind.VEHICLE:
        world.fleet.control[actor.index] = (0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0)


@methods.void("set_actor_autopilot")
def accept(session: ClientSession, actor_id: int, *_: Any) -> None:
    """Accept the call without effect: the traffic manager runs in the client."""
    session.actor(actor_id, "set_actor_autopilot")
