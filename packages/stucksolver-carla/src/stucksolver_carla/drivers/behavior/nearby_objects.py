"""Ground truth of all bodies around the ego, one snapshot per tick, as arrays.

`BehaviorAgent` looks at vehicles and walkers only; here every actor with a body counts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar, NamedTuple, Protocol

import carla
import numpy as np

from stucksolver_carla.drivers.behavior.path import Array

BODILESS = ("sensor.", "traffic.", "controller.", "spectator", "static.trigger")
MIN_HEIGHT_M = 0.05
"""Anything flatter is a mark on the road."""
HAZARD_LAMPS = 32 | 16
"""Both blinkers, as bits of `carla.VehicleLightState`."""
RANGE_M = 120.0
FIRST_FAR_ID = 1_000_000
"""By sensors, ids from this one on are of vehicles that only a camera tracks
(`stucksolver_perception.far_tracking.FIRST_ID`). They are on a lane of the map and nearer than measured, to be
careful: where that is says nothing of the way that they take.
"""
_UNKNOWN_HALF_SIZE_M = 0.3


class ActorBox(NamedTuple):
    """Box of one actor, measured once: half sizes and the box's place in the actor's frame (m, rad)."""

    actor_id: int
    is_walker: bool
    half_length: float
    half_width: float
    half_height: float
    offset: tuple[float, float, float]
    yaw: float


@dataclass(frozen=True, eq=False)
class NearbyObjects:
    """Oriented boxes of the actors within range; CARLA's world frame, meters, radians, m/s; equal lengths."""

    actor_id: tuple[int, ...]
    is_walker: np.ndarray[Any, np.dtype[np.bool_]]
    x: Array
    y: Array
    yaw: Array
    half_length: Array
    half_width: Array
    bottom: Array
    top: Array
    vx: Array
    vy: Array

    def __len__(self) -> int:
        return len(self.actor_id)

    def part(self, which: np.ndarray[Any, np.dtype[np.bool_]]) -> NearbyObjects:
        """Some of them."""
        ids = tuple(i for i, wanted in zip(self.actor_id, which.tolist(), strict=True) if wanted)
        columns = {f.name: getattr(self, f.name)[which] for f in fields(self) if f.name != "actor_id"}
        return NearbyObjects(actor_id=ids, **columns)


class ObjectSource(Protocol):
    """Returns the bodies around: `GroundTruthObjects` from the client, a vehicle's own perception from its sensors."""

    doubt_m: ClassVar[float]
    """How far the ego and stationary bodies may be from where they are taken to be (m); 0 for ground truth."""

    def read(self, ego_x: float, ego_y: float) -> NearbyObjects:
        """Return the bodies within range of a point of CARLA's world."""


def bodies_around(vehicle: Any, range_m: float, unseen: tuple[str, ...]) -> ObjectSource:
    """Return the vehicle's own perception (`SensedVehicle.perceiver`), or else the client's ground truth."""
    own = getattr(vehicle, "perceiver", None)
    if own is None:
        return GroundTruthObjects(vehicle.get_world(), vehicle.id, range_m, unseen)
    found: ObjectSource = own.within(range_m)
    return found


class GroundTruthObjects:
    """Reads the world for one ego; requests actors and their sizes only if the set of ids changes."""

    doubt_m: ClassVar[float] = 0.0

    def __init__(
        self, world: carla.World, ego_id: int, range_m: float = RANGE_M, unseen: tuple[str, ...] = BODILESS
    ) -> None:
        self._world = world
        self._ego_id = ego_id
        self._range_m = range_m
        self._unseen = unseen
        self._ids: frozenset[int] = frozenset()
        self._bodies: dict[int, ActorBox | None] = {}

    def read(self, ego_x: float, ego_y: float) -> NearbyObjects:
        """Return the bodies within range (a square) of a point of CARLA's world."""
        snapshot = self._world.get_snapshot()
        self._refresh(frozenset(actor.id for actor in snapshot))
        rows = []
        for body in self._bodies.values():
            actor = None if body is None else snapshot.find(body.actor_id)
            if body is not None and actor is not None:
                row = _row(body, actor)
                if abs(row[0] - ego_x) < self._range_m and abs(row[1] - ego_y) < self._range_m:
                    rows.append((body, row))
        return _surroundings(rows)

    def _refresh(self, ids: frozenset[int]) -> None:
        if ids == self._ids:
            return
        for gone in self._bodies.keys() - ids:
            del self._bodies[gone]
        new = ids - self._bodies.keys()
        if new:
            listed = {actor.id: actor for actor in self._world.get_actors(list(new))}
            # An id that the server does not list yet is requested again on the next tick.
            self._bodies.update({i: self._measure(actor) for i, actor in listed.items()})
            ids = ids - (new - listed.keys())
        self._ids = ids

    def _measure(self, actor: carla.Actor) -> ActorBox | None:
        if actor.id == self._ego_id or actor.type_id.startswith(self._unseen):
            return None
        if actor.parent is not None and actor.parent.id == self._ego_id:
            return None
        return body_of(actor)


def body_of(actor: carla.Actor) -> ActorBox | None:
    """Return the box of a `carla.Actor`; None for one that is too flat to matter."""
    # Old clients know the boxes of vehicles and walkers only.
    box = getattr(actor, "bounding_box", None) or carla.BoundingBox()
    size = [float(box.extent.x), float(box.extent.y), float(box.extent.z)]
    # Some props of CARLA report no or infinite size: then it is unknown, which must not mean harmless.
    if not all(map(math.isfinite, size)) or max(size[0], size[1]) <= 0.0:
        size = [_UNKNOWN_HALF_SIZE_M] * 3
    if 2.0 * size[2] < MIN_HEIGHT_M:
        return None
    offset = (float(box.location.x), float(box.location.y), float(box.location.z))
    if not all(map(math.isfinite, offset)):
        offset = (0.0, 0.0, size[2])
    yaw = math.radians(box.rotation.yaw)
    return ActorBox(actor.id, actor.type_id.startswith(("walker.", "animal.")), size[0], size[1], size[2], offset, yaw)


def _row(body: ActorBox, actor: carla.ActorSnapshot) -> tuple[float, float, float, float, float, float, float]:
    """x, y, yaw, bottom, top, vx, vy of the box's center."""
    transform, velocity = actor.get_transform(), actor.get_velocity()
    place, yaw = transform.location, math.radians(transform.rotation.yaw)
    cos, sin = math.cos(yaw), math.sin(yaw)
    dx, dy, dz = body.offset
    z = place.z + dz
    return (
        place.x + dx * cos - dy * sin,
        place.y + dx * sin + dy * cos,
        yaw + body.yaw,
        z - body.half_height,
        z + body.half_height,
        velocity.x,
        velocity.y,
    )


def _surroundings(rows: Sequence[tuple[ActorBox, tuple[float, ...]]]) -> NearbyObjects:
    columns = np.array([row for _, row in rows], dtype=np.float64).reshape(len(rows), 7).T
    x, y, yaw, bottom, top, vx, vy = columns
    return NearbyObjects(
        actor_id=tuple(body.actor_id for body, _ in rows),
        is_walker=np.array([body.is_walker for body, _ in rows], dtype=np.bool_),
        x=x,
        y=y,
        yaw=yaw,
        half_length=np.array([body.half_length for body, _ in rows], dtype=np.float64),
        half_width=np.array([body.half_width for body, _ in rows], dtype=np.float64),
        bottom=bottom,
        top=top,
        vx=vx,
        vy=vy,
    )
