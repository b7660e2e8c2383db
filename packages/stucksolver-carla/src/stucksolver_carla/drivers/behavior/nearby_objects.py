"""Reads the boxes of all objects around the ego from ground truth, one snapshot per tick, as arrays.

`BehaviorAgent` uses vehicles and walkers only; this driver uses every actor with a body.
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
"""Starts of the type ids of actors without a body."""
MIN_HEIGHT_M = 0.05
"""Minimum height of an object (m); flatter ones are marks on the road. Ours."""
HAZARD_LAMPS = 32 | 16
"""Both blinkers, as bits of `carla.VehicleLightState`."""
RANGE_M = 120.0
"""Half size of the square around the ego from which objects are read (m). Ours."""
FIRST_FAR_ID = 1_000_000
"""First id of vehicles that only a camera tracks (`stucksolver_perception.far_tracking.FIRST_ID`). Sensor mode only.

Such a vehicle is placed on a lane of the map, nearer than measured, as a safe assumption. This position does not tell
which path the vehicle takes."""
_UNKNOWN_HALF_SIZE_M = 0.3
"""Half size of an object whose size the client does not report (m). Ours."""


class ActorBox(NamedTuple):
    """Box of one actor, read once: half sizes and the box's pose in the actor's frame (m, rad)."""

    actor_id: int
    is_walker: bool
    half_length: float
    half_width: float
    half_height: float
    offset: tuple[float, float, float]
    yaw: float


@dataclass(frozen=True, eq=False)
class NearbyObjects:
    """Oriented boxes of the actors within range, in CARLA's world frame (m, rad, m/s); arrays of equal length."""

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

    def part(self, selected: np.ndarray[Any, np.dtype[np.bool_]]) -> NearbyObjects:
        """Return the selected objects."""
        ids = tuple(i for i, is_selected in zip(self.actor_id, selected.tolist(), strict=True) if is_selected)
        columns = {f.name: getattr(self, f.name)[selected] for f in fields(self) if f.name != "actor_id"}
        return NearbyObjects(actor_id=ids, **columns)


class ObjectSource(Protocol):
    """Source of the objects around the ego: `GroundTruthObjects` from the client, or sensor-based perception."""

    doubt_m: ClassVar[float]
    """Maximum error of the positions of the ego and of stationary objects (m); 0 for ground truth."""

    def read(self, ego_x: float, ego_y: float) -> NearbyObjects:
        """Return the objects within range of a point in CARLA's world frame (m)."""


def bodies_around(vehicle: Any, range_m: float, ignored_types: tuple[str, ...]) -> ObjectSource:
    """Return the vehicle's sensor-based perception (its attribute `perceiver`), or the client's ground truth."""
    own = getattr(vehicle, "perceiver", None)
    if own is None:
        return GroundTruthObjects(vehicle.get_world(), vehicle.id, range_m, ignored_types)
    source: ObjectSource = own.within(range_m)
    return source


class GroundTruthObjects:
    """The ground truth around one ego. Actors and their sizes are requested only if the set of ids changes."""

    doubt_m: ClassVar[float] = 0.0

    def __init__(
        self, world: carla.World, ego_id: int, range_m: float = RANGE_M, ignored_types: tuple[str, ...] = BODILESS
    ) -> None:
        self._world = world
        self._ego_id = ego_id
        self._range_m = range_m
        self._ignored_types = ignored_types
        self._ids: frozenset[int] = frozenset()
        self._boxes: dict[int, ActorBox | None] = {}

    def read(self, ego_x: float, ego_y: float) -> NearbyObjects:
        """Return the objects in a square around a point in CARLA's world frame (m)."""
        snapshot = self._world.get_snapshot()
        self._refresh(frozenset(actor.id for actor in snapshot))
        rows = []
        for body in self._boxes.values():
            actor = None if body is None else snapshot.find(body.actor_id)
            if body is not None and actor is not None:
                row = _row(body, actor)
                if abs(row[0] - ego_x) < self._range_m and abs(row[1] - ego_y) < self._range_m:
                    rows.append((body, row))
        return _nearby_objects(rows)

    def _refresh(self, ids: frozenset[int]) -> None:
        if ids == self._ids:
            return
        for removed_id in self._boxes.keys() - ids:
            del self._boxes[removed_id]
        new_ids = ids - self._boxes.keys()
        if new_ids:
            listed = {actor.id: actor for actor in self._world.get_actors(list(new_ids))}
            # An id that the server does not list yet is requested again on the next tick.
            self._boxes.update({i: self._measure(actor) for i, actor in listed.items()})
            ids = ids - (new_ids - listed.keys())
        self._ids = ids

    def _measure(self, actor: carla.Actor) -> ActorBox | None:
        if actor.id == self._ego_id or actor.type_id.startswith(self._ignored_types):
            return None
        if actor.parent is not None and actor.parent.id == self._ego_id:
            return None
        return body_of(actor)


def body_of(actor: carla.Actor) -> ActorBox | None:
    """Return the box of a `carla.Actor`; None if it is flatter than `MIN_HEIGHT_M`."""
    # Old clients have boxes only for vehicles and walkers.
    box = getattr(actor, "bounding_box", None) or carla.BoundingBox()
    size = [float(box.extent.x), float(box.extent.y), float(box.extent.z)]
    # Some props of CARLA have no or infinite size. They still count as obstacles, with a default size.
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
    """Return x, y, yaw, bottom, top, vx, vy of a box."""
    transform, velocity = actor.get_transform(), actor.get_velocity()
    location, yaw = transform.location, math.radians(transform.rotation.yaw)
    cos, sin = math.cos(yaw), math.sin(yaw)
    dx, dy, dz = body.offset
    z = location.z + dz
    return (
        location.x + dx * cos - dy * sin,
        location.y + dx * sin + dy * cos,
        yaw + body.yaw,
        z - body.half_height,
        z + body.half_height,
        velocity.x,
        velocity.y,
    )


def _nearby_objects(rows: Sequence[tuple[ActorBox, tuple[float, ...]]]) -> NearbyObjects:
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
