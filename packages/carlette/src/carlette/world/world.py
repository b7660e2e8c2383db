"""The world of one episode: actors, their motion, lights, weather, and the tick that advances them."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from carlette.errors import UnknownActorError
from carlette.geometry import Box, Pose, Vector, turned
from carlette.opendrive.map_file import check_opendrive
from carlette.opendrive.road_network import RoadNetwork
from carlette.opendrive.signals import ACTOR_TYPES, LIGHT_TYPE, read_signals
from carlette.physics.ackermann import Ackermann
from carlette.physics.bodies import BodyTable
from carlette.physics.contacts import Contact, collide
from carlette.physics.doors import OpenDoors
from carlette.physics.props import LooseProps
from carlette.physics.surface import Surface
from carlette.physics.vehicle_dynamics import STEER, Vehicles
from carlette.physics.walkers import LIES_S, Walkers
from carlette.world.actor import Actor, ActorKind, Attributes
from carlette.world.fork import fork, shared
from carlette.world.settings import CLEAR_NOON, EpisodeSettings
from carlette.world.speed_limits import pass_signs
from carlette.world.traffic_light_triggers import watch_lights
from carlette.world.traffic_lights import Signals

SPECTATOR = "spectator"
shared(RoadNetwork)


class Drivers(Protocol):
    """Sets the controls of cars at the start of a tick."""

    def step(self, world: World, /) -> None:
        """Set the controls for the tick that begins."""


@dataclass(frozen=True)
class Collision:
    """Data of a collision sensor: the two actors, and the impulse on the first (N·s)."""

    sensor_id: int
    actor_id: int
    other_id: int
    impulse: Vector


class World:
    """Content of a snapshot. `tick` is a pure function of the state: it uses no clock and no hidden randomness."""

    def __init__(self, roads: RoadNetwork, seed: int = 0, first_id: int = 1) -> None:
        self.roads = roads
        self.settings = EpisodeSettings()
        self.weather: tuple[float, ...] = CLEAR_NOON
        self.frame = 0
        self.elapsed_s = 0.0
        self.bodies = BodyTable()
        self.fleet = Vehicles()
        self.walkers = Walkers()
        self.props = LooseProps()
        self.surface = Surface()
        self.doors = OpenDoors()
        self.ackermanns: dict[int, Ackermann] = {}
        """Ackermann controllers by vehicle id."""
        self.signals = Signals()
        self.actors: dict[int, Actor] = {}
        self.collisions: list[Collision] = []
        self.contacts: list[Contact] = []
        """The collisions of the last tick."""
        self.traffic: Drivers | None = None
        """Drivers of cars inside the world, as in forks (`carlette.traffic.Traffic`); None if only clients drive."""
        self._next_id = first_id
        self.spectator = self.enter(SPECTATOR, ActorKind.OTHER, Pose(), Box(Vector(), Vector()))
        self._install_signals(Random(seed))

    @property
    def step_s(self) -> float:
        """Duration of the next tick (s), rounded to the snapshot's float32."""
        return self.settings.single_step_s

    @property
    def next_id(self) -> int:
        """Id of the next actor."""
        return self._next_id

    @property
    def roster(self) -> tuple[int, int]:
        """Value that changes when an actor is added or removed."""
        return len(self.actors), self._next_id

    def fork(self) -> World:
        """Return an independent world in the same state: with the same commands it develops identically, bit for bit.

        It requires no server: `tick` advances it. Only the map, which never changes, is shared.
        """
        return fork(self)

    def actor(self, actor_id: int, method: str) -> Actor:
        """Return the actor with an id; an `UnknownActorError` names `method`."""
        found = self.actors.get(actor_id)
        if found is None:
            raise UnknownActorError(actor_id, method)
        return found

    def enter(self, type_id: str, kind: ActorKind, pose: Pose, box: Box, attributes: Attributes | None = None) -> Actor:
        """Add an actor without any check (clients use `world.spawn`)."""
        row = self.bodies.append(position=pose.location, rotation=pose.rotation, center=box.center, extent=box.extent)
        actor = Actor(self._next_id, type_id, kind, row, box, attributes or {})
        self._next_id += 1
        self.actors[actor.id] = actor
        record = self.bodies.record
        record["id"][row] = actor.id
        record["state"][row] = 1
        return actor

    def remove(self, actor_id: int) -> bool:
        """Remove an actor from the world; return False if there is none."""
        actor = self.actors.pop(actor_id, None)
        if actor is None:
            return False
        table = {ActorKind.VEHICLE: self.fleet, ActorKind.WALKER: self.walkers, ActorKind.PROP: self.props}.get(
            actor.kind
        )
        if table is not None and actor.index >= 0:
            table.delete(actor.index)
        if actor.surface >= 0:
            self.surface.delete(actor.surface)
        self.doors.forget(actor.row)
        self.ackermanns.pop(actor_id, None)
        self._let_go(actor_id)
        self.bodies.delete(actor.row)
        self._close_gaps(actor)
        return True

    def _let_go(self, parent_id: int) -> None:
        """Detach the children of an actor. As in Unreal, they stay where they are and keep their parent's id."""
        for child in self.actors.values():
            if child.parent_id == parent_id and child.attached is not None:
                child.attached = None
                self.bodies.velocity[child.row] = self.bodies.angular[child.row] = 0.0

    def _close_gaps(self, gone: Actor) -> None:
        for other in self.actors.values():
            other.row -= other.row > gone.row
            if gone.index >= 0 and other.kind == gone.kind:
                other.index -= other.index > gone.index
            if gone.surface >= 0:
                other.surface -= other.surface > gone.surface
        for table in (self.fleet, self.walkers, self.props, self.surface, self.doors, self.signals.lights):
            table.row[table.row > gone.row] -= 1

    def pose(self, actor: Actor) -> Pose:
        """Return the pose of an actor."""
        return self.bodies.pose(actor.row)

    def teleport(self, actor: Actor, pose: Pose) -> None:
        """Move an actor (an attached one in its parent's frame); its velocity is unchanged."""
        if actor.attached is not None:
            actor.attached = pose
            return
        self.bodies.set_pose(actor.row, pose)
        if actor.surface >= 0:
            self.surface.looked[actor.surface] = np.inf
        if actor.kind is ActorKind.PROP:
            self.turn_prop(actor)

    def turn_prop(self, actor: Actor) -> None:
        """Make a prop's collision box follow its pitch and roll: a gate opens, a barrier falls over."""
        box = turned(actor.box, self.pose(actor).rotation)
        self.bodies.center[actor.row], self.bodies.extent[actor.row] = box.center, box.extent

    def tick(self) -> int:
        """Advance the world by one step and return the new frame number."""
        dt = self.step_s
        bodies = self.bodies
        if self.traffic is not None:
            self.traffic.step(self)
        if len(self.walkers) and self.walkers.dead.any():
            self._bury()
        before = bodies.velocity.copy()
        self.signals.step(bodies, dt)
        if len(self.surface):
            self.surface.update(bodies, self.roads)
        if len(self.fleet):
            self._steer_by_ackermann(dt)
            self.fleet.step(bodies, dt)
        if len(self.walkers):
            self.walkers.step(bodies, self._walkers_in_the_air(), dt)
        if len(self.props):
            self.props.step(bodies, dt)
        if len(self.doors):
            self.doors.step(dt)
        self._collide()
        if len(self.surface):
            self.surface.settle(bodies, dt)
        self._follow_parents()
        bodies.acceleration = (bodies.velocity - before) / dt
        watch_lights(bodies, self.fleet, self.signals.lights)
        pass_signs(bodies, self.fleet, self.roads.speed_boxes)
        bodies.publish()
        self.frame += 1
        self.elapsed_s += dt
        return self.frame

    def _steer_by_ackermann(self, dt: float) -> None:
        for actor_id, controller in self.ackermanns.items():
            if controller.active:
                index, row = self.actors[actor_id].index, self.actors[actor_id].row
                yaw = np.radians(self.bodies.rotation[row, 1])
                ahead = float(self.bodies.velocity[row, 0] * np.cos(yaw) + self.bodies.velocity[row, 1] * np.sin(yaw))
                steer, lock = float(self.fleet.control[index, STEER]), float(self.fleet.max_steer[index])
                self.fleet.control[index] = controller.control(ahead, steer, lock, dt)

    def _collide(self) -> None:
        self.collisions, self.contacts = [], []
        if not self.bodies.solid.any():
            return
        contacts = self.contacts = collide(self.bodies, self.doors)
        if contacts:
            self.walkers.take_push(self.bodies)
            self.walkers.wound(self.bodies, contacts, set(self.fleet.row.tolist()))
            self._report(contacts)

    def _report(self, contacts: list[Contact]) -> None:
        ids = self.bodies.record["id"]
        sensors: dict[int, list[int]] = {}
        for actor in self.actors.values():
            if actor.type_id == "sensor.other.collision":
                sensors.setdefault(actor.parent_id, []).append(actor.id)
        for contact in contacts:
            first, second = int(ids[contact.first]), int(ids[contact.second])
            back = Vector(-contact.impulse.x, -contact.impulse.y, -contact.impulse.z)
            for item, other, impulse in ((first, second, back), (second, first, contact.impulse)):
                self.collisions += [Collision(sensor, item, other, impulse) for sensor in sensors.get(item, ())]

    def _walkers_in_the_air(self) -> NDArray[np.bool_]:
        up = np.zeros(len(self.bodies), bool)
        up[self.surface.row] = self.surface.airborne(self.bodies)
        among_walkers: NDArray[np.bool_] = up[self.walkers.row]
        return among_walkers

    def _bury(self) -> None:
        """Remove the walkers that have been dead long enough."""
        rows = set(self.walkers.row[self.walkers.dead_s > LIES_S].tolist())
        for actor_id in [actor.id for actor in self.actors.values() if actor.row in rows]:
            self.remove(actor_id)

    def _follow_parents(self) -> None:
        for actor in self.actors.values():
            if actor.attached is not None:
                parent = self.actors.get(actor.parent_id)
                if parent is not None:
                    self.bodies.set_pose(actor.row, self.pose(parent).compose(actor.attached))
                    self.bodies.velocity[actor.row] = self.bodies.velocity[parent.row]

    def _install_signals(self, random: Random) -> None:
        root = check_opendrive(self.roads.file.text, self.roads.file.name)
        turns = []
        for signal in read_signals(self.roads, root):
            is_light = signal.type == LIGHT_TYPE
            actor = self.enter(
                ACTOR_TYPES[signal.type], ActorKind.LIGHT if is_light else ActorKind.SIGN, signal.pose, signal.box
            )
            self.bodies.record["sign_id"][actor.row] = signal.id.encode()[:31].decode(errors="ignore").encode()
            if is_light:
                yaw = np.radians(signal.pose.rotation.yaw)
                actor.index = self.signals.lights.append(
                    row=actor.row,
                    center=signal.pose.apply(signal.box.center),
                    extent=signal.box.extent,
                    ahead=(np.cos(yaw), np.sin(yaw)),
                )
                turns.append(signal.turn)
        self.signals.form_groups(turns, random)
        self.signals.publish(self.bodies)
        self.bodies.publish()
