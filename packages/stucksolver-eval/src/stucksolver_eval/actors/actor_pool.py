"""All actors that a run spawns. Each tick has one snapshot and one batch of commands for all of them."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from random import Random
from typing import Any, NamedTuple

import carla

LIFT_M = 0.2
"""Vehicles are spawned slightly above the road, as in CARLA's own scenarios."""
DEPOT_M, DEPOT_SPACING_M, DEPOT_DEPTH_M = 1500.0, 20.0, 100.0
"""Position of staged actors: distance, spacing and depth below the ground (m). There no sensor detects them. Ours."""


class CastError(RuntimeError):
    """An actor that a scenario requires could not be spawned."""


@dataclass(eq=False)
class ScenarioActor:
    """One spawned actor, with the half sizes of its bounding box (m)."""

    id: int
    type_id: str
    actor: Any
    """The `carla.Actor`."""
    half_length_m: float
    half_width_m: float
    half_height_m: float
    middle_m: tuple[float, float] = (0.0, 0.0)
    """Center of the box relative to the actor's origin: forward, right (m)."""
    is_staged: bool = False

    @property
    def is_walker(self) -> bool:
        """True for walkers: people and animals."""
        return self.type_id.startswith("walker.")


class ActorState(NamedTuple):
    """Pose and velocity in CARLA's left-handed world frame (m, rad, m/s); `speed_mps` is along the heading."""

    x: float
    y: float
    z: float
    yaw_rad: float
    vx: float
    vy: float
    speed_mps: float

    def distance_m(self, x: float, y: float) -> float:
        """Return the distance to a position in the plane (m)."""
        return math.hypot(self.x - x, self.y - y)

    def ahead_m(self, x: float, y: float) -> float:
        """Return how far a position is ahead of the actor (m); negative behind it."""
        return (x - self.x) * math.cos(self.yaw_rad) + (y - self.y) * math.sin(self.yaw_rad)


class ActorPool:
    """The actors of one run, the hero's state, and the commands of this tick."""

    def __init__(self, client: carla.Client, world: carla.World, hero: carla.Vehicle) -> None:
        self._client, self._world = client, world
        self._library = world.get_blueprint_library()
        self._snapshot = world.get_snapshot()
        self._states: dict[int, ActorState] = {}
        self._commands: list[Any] = []
        self._boxes: dict[str, Any] = {}
        self._depot_places = 0
        self.members: dict[int, ScenarioActor] = {}
        self.doors_open: dict[int, int] = {}
        """Doors opened by `open_door`, by the vehicle's id: bit `1 << n` for the n-th of `carla.VehicleDoor`.

        The client API cannot report them.
        """
        self.hero_member = _member(hero, hero.bounding_box)

    def take_snapshot(self) -> None:
        """Take this tick's snapshot and discard the states of the last one."""
        self._snapshot = self._world.get_snapshot()
        self._states.clear()

    def flush(self) -> None:
        """Send this tick's commands in one batch, without waiting for the result."""
        if self._commands:
            self._client.apply_batch(self._commands)
            self._commands = []

    @property
    def time_s(self) -> float:
        """Simulation time (s)."""
        return float(self._snapshot.timestamp.elapsed_seconds)

    @property
    def hero(self) -> ActorState:
        """State of the vehicle under test at this tick."""
        return self.state(self.hero_member)

    def state(self, member: ScenarioActor) -> ActorState:
        """Return an actor's state in this tick's snapshot, or its spawn pose if it is not in the snapshot yet."""
        known = self._states.get(member.id)
        if known is None:
            shot = self._snapshot.find(member.id)
            known = _state(member.actor if shot is None else shot)
            self._states[member.id] = known
        return known

    def knows(self, blueprint: str) -> bool:
        """Return True if the blueprint library contains this blueprint."""
        return blueprint in self._ids

    def kinds(self, **attributes: str) -> tuple[str, ...]:
        """Return the ids of the vehicle blueprints with these attributes, sorted."""
        return tuple(
            definition.id
            for definition in sorted(self._library.filter("vehicle.*"), key=lambda item: str(item.id))
            if all(_attribute(definition, name) == value for name, value in attributes.items())
        )

    @cached_property
    def car_kinds(self) -> tuple[str, ...]:
        """Blueprint ids of ordinary cars with lights, which traffic consists of."""
        emergency = set(self.kinds(special_type="emergency"))
        return tuple(kind for kind in self.kinds(base_type="car", has_lights="true") if kind not in emergency)

    def some_car(self, chance: Random) -> str:
        """Return a random one of `car_kinds`."""
        return chance.choice(self.car_kinds)

    def spawn(
        self,
        blueprint: str,
        transform: carla.Transform,
        role: str = "scenario",
        lift_m: float = LIFT_M,
        **attributes: str,
    ) -> ScenarioActor | None:
        """Spawn an actor `lift_m` above a pose. Returns None if the position is occupied."""
        definition = self._library.find(blueprint)
        definition.set_attribute("role_name", role)
        for name, value in attributes.items():
            definition.set_attribute(name, value)
        place = carla.Transform(_lifted(transform.location, lift_m), transform.rotation)
        actor = self._world.try_spawn_actor(definition, place)
        return None if actor is None else self._enter(actor, place)

    def must_spawn(self, blueprint: str, transform: carla.Transform, **options: Any) -> ScenarioActor:
        """Spawn an actor like `spawn`. Raises `CastError` if the position is occupied."""
        member = self.spawn(blueprint, transform, **options)
        if member is None:
            at = transform.location
            raise CastError(f"position occupied: {blueprint} at ({at.x:.1f}, {at.y:.1f}). Move the trigger point")
        return member

    def keep_below(self, blueprint: str, **options: Any) -> ScenarioActor:
        """Spawn an actor that stays below the ground until `bring` places it. Raises `CastError`."""
        self._depot_places += 1
        place = carla.Location(DEPOT_M, DEPOT_SPACING_M * self._depot_places, -DEPOT_DEPTH_M)
        member = self.must_spawn(blueprint, carla.Transform(place), lift_m=0.0, **options)
        member.actor.set_simulate_physics(False)
        member.is_staged = True
        return member

    def bring(self, member: ScenarioActor, transform: carla.Transform, lift_m: float = LIFT_M) -> None:
        """Move a staged actor to its position in the world and switch on its physics."""
        place = carla.Transform(_lifted(transform.location, lift_m), transform.rotation)
        self.send(carla.command.ApplyTransform(member.id, place))
        if not member.type_id.startswith("static."):
            self.send(carla.command.SetSimulatePhysics(member.id, True))
        member.is_staged = False
        self._states[member.id] = _pose_state(place)

    def teleport(self, member: ScenarioActor, transform: carla.Transform) -> None:
        """Teleport an actor to a pose."""
        self.send(carla.command.ApplyTransform(member.id, transform))
        self._states[member.id] = _pose_state(transform)

    def hold(self, member: ScenarioActor) -> None:
        """Apply the hand brake, so that a vehicle stays where it is."""
        self.send(carla.command.ApplyVehicleControl(member.id, carla.VehicleControl(hand_brake=True, brake=1.0)))

    def walk(self, member: ScenarioActor, x: float, y: float, speed_mps: float) -> None:
        """Let a walker go in direction (`x`, `y`) of the world frame until the next call; speed 0 stops it."""
        control = carla.WalkerControl(carla.Vector3D(x, y, 0.0), speed_mps, False)
        self.send(carla.command.ApplyWalkerControl(member.id, control))

    def open_door(self, member: ScenarioActor, door: carla.VehicleDoor) -> None:
        """Open a door of a vehicle permanently."""
        member.actor.open_door(door)
        self.doors_open[member.id] = self.doors_open.get(member.id, 0) | 1 << int(door)

    def lights(self, member: ScenarioActor, state: Any) -> None:
        """Set a vehicle's lamps to a `carla.VehicleLightState`."""
        self.send(carla.command.SetVehicleLightState(member.id, state))

    def send(self, command: Any) -> None:
        """Add a command to this tick's batch."""
        self._commands.append(command)

    def remove(self, members: Sequence[ScenarioActor]) -> None:
        """Destroy actors with this tick's batch."""
        for member in members:
            if self.members.pop(member.id, None) is not None:
                self.send(carla.command.DestroyActor(member.id))

    def close(self) -> None:
        """Destroy all actors."""
        self.remove(list(self.members.values()))
        # The server may already have ended, and then its actors are gone too.
        with contextlib.suppress(RuntimeError):
            self.flush()

    @cached_property
    def _ids(self) -> frozenset[str]:
        return frozenset(str(definition.id) for definition in self._library)

    def _enter(self, actor: carla.Actor, place: Any) -> ScenarioActor:
        box = self._boxes.get(actor.type_id)
        if box is None:
            box = self._boxes[actor.type_id] = actor.bounding_box
        member = _member(actor, box)
        self.members[member.id] = member
        self._states[member.id] = _pose_state(place)
        return member


def lamps(*names: str) -> carla.VehicleLightState:
    """Return vehicle lights by name: `lamps("LeftBlinker", "RightBlinker")` are the hazard lights."""
    value = 0
    for name in names:
        value |= int(getattr(carla.VehicleLightState, name))
    return carla.VehicleLightState(value)


HAZARD_LAMPS = ("LeftBlinker", "RightBlinker")


def _member(actor: carla.Actor, box: Any) -> ScenarioActor:
    half, middle = box.extent, box.location
    return ScenarioActor(actor.id, actor.type_id, actor, half.x, half.y, half.z, (middle.x, middle.y))


def _state(shot: Any) -> ActorState:
    transform, velocity = shot.get_transform(), shot.get_velocity()
    place, yaw = transform.location, math.radians(transform.rotation.yaw)
    vx, vy = velocity.x, velocity.y
    return ActorState(place.x, place.y, place.z, yaw, vx, vy, vx * math.cos(yaw) + vy * math.sin(yaw))


def _pose_state(transform: carla.Transform) -> ActorState:
    place = transform.location
    return ActorState(place.x, place.y, place.z, math.radians(transform.rotation.yaw), 0.0, 0.0, 0.0)


def _lifted(location: carla.Location, lift_m: float) -> carla.Location:
    return carla.Location(location.x, location.y, location.z + lift_m)


def _attribute(definition: Any, name: str) -> str:
    if not definition.has_attribute(name):
        return ""
    attribute = definition.get_attribute(name)
    if attribute.type == carla.ActorAttributeType.Bool:
        return str(attribute.as_bool()).lower()
    return str(attribute.as_int()) if attribute.type == carla.ActorAttributeType.Int else str(attribute.as_str())
