"""The bodies around a vehicle: each actor's box, requested once, and its pose from the client's snapshots."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

BODILESS = ("sensor.", "traffic.", "controller.", "spectator", "static.trigger")
ATTRIBUTES = ("special_type", "base_type", "number_of_wheels")
"""Attributes that a perception system could recognize. The role name is never among them."""
UNKNOWN_SIZE_M = 0.3
"""Half size of an object whose size the client does not know: unknown must not mean harmless."""


class BridgeActorBox(NamedTuple):
    """An actor's box: half sizes and the box's place in the actor's frame (meters, radians)."""

    actor: Any
    half_length_m: float
    half_width_m: float
    half_height_m: float
    offset: tuple[float, float, float]
    yaw_rad: float


class PlacedBox(NamedTuple):
    """A body at this tick. The position is its box's center in CARLA's world."""

    body: BridgeActorBox
    x: float
    y: float
    z: float
    yaw_rad: float
    vx: float
    vy: float


class ActorBoxes:
    """All bodies in the world except one vehicle and what is attached to it."""

    def __init__(self, world: Any, ego_id: int) -> None:
        self._world = world
        self._ego_id = ego_id
        self._known: dict[int, BridgeActorBox | None] = {}
        self._ids: frozenset[int] = frozenset()

    def refresh(self, snapshot: Any) -> dict[int, BridgeActorBox]:
        """Return the bodies of a snapshot, by id."""
        ids = frozenset(actor.id for actor in snapshot)
        if ids != self._ids:
            for gone in self._known.keys() - ids:
                del self._known[gone]
            new = list(ids - self._known.keys())
            listed = {actor.id: actor for actor in self._world.get_actors(new)} if new else {}
            self._known.update({i: self._measured(actor) for i, actor in listed.items()})
            # Actors that the server does not list yet are requested again on the next tick.
            self._ids = ids - (frozenset(new) - listed.keys())
        return {i: body for i, body in self._known.items() if body is not None}

    def near(self, x: float, y: float, range_m: float) -> list[PlacedBox]:
        """Return the bodies within a square around a place."""
        snapshot = self._world.get_snapshot()
        found = []
        for actor_id, body in self.refresh(snapshot).items():
            actor = snapshot.find(actor_id)
            if actor is None:
                continue
            place = placed(body, actor)
            if abs(place.x - x) < range_m and abs(place.y - y) < range_m:
                found.append(place)
        return found

    def _measured(self, actor: Any) -> BridgeActorBox | None:
        if actor.id == self._ego_id or actor.type_id.startswith(BODILESS):
            return None
        if actor.parent is not None and actor.parent.id == self._ego_id:
            return None
        return measured(actor)


def measured(actor: Any) -> BridgeActorBox:
    """Return the box of a `carla.Actor`. Old clients know only the boxes of vehicles and walkers."""
    box = getattr(actor, "bounding_box", None)
    size = [UNKNOWN_SIZE_M] * 3
    offset = (0.0, 0.0, UNKNOWN_SIZE_M)
    yaw = 0.0
    if box is not None:
        given = [float(box.extent.x), float(box.extent.y), float(box.extent.z)]
        if all(map(math.isfinite, given)) and max(given[0], given[1]) > 0.0:
            size = given
            place = (float(box.location.x), float(box.location.y), float(box.location.z))
            offset = place if all(map(math.isfinite, place)) else (0.0, 0.0, size[2])
            yaw = math.radians(box.rotation.yaw)
    return BridgeActorBox(actor, size[0], size[1], size[2], offset, yaw)


def placed(body: BridgeActorBox, actor: Any) -> PlacedBox:
    """Return a body at the position of the snapshot's actor."""
    transform, velocity = actor.get_transform(), actor.get_velocity()
    yaw = math.radians(transform.rotation.yaw)
    cos, sin = math.cos(yaw), math.sin(yaw)
    dx, dy, dz = body.offset
    return PlacedBox(
        body,
        transform.location.x + dx * cos - dy * sin,
        transform.location.y + dx * sin + dy * cos,
        transform.location.z + dz,
        yaw + body.yaw_rad,
        velocity.x,
        velocity.y,
    )
