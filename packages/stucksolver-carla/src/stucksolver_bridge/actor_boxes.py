"""Finds the boxes around a vehicle. Each actor's box is requested once; its pose comes from the client's snapshots."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

BODILESS = ("sensor.", "traffic.", "controller.", "spectator", "static.trigger")
"""Starts of the type ids of actors without a body."""
ATTRIBUTES = ("special_type", "base_type", "number_of_wheels")
"""Attributes that a perception system could recognize. The role name is never among them."""
UNKNOWN_SIZE_M = 0.3
"""Half size of an object whose size the client does not report (m). It still counts as an obstacle. Ours."""


class BridgeActorBox(NamedTuple):
    """An actor's box: half sizes and the box's pose in the actor's frame (m, rad)."""

    actor: Any
    half_length_m: float
    half_width_m: float
    half_height_m: float
    offset: tuple[float, float, float]
    yaw_rad: float


class PlacedBox(NamedTuple):
    """A box at the present tick. The position is the box's center in CARLA's world frame (m)."""

    body: BridgeActorBox
    x: float
    y: float
    z: float
    yaw_rad: float
    vx: float
    vy: float


class ActorBoxes:
    """Boxes of all actors except the ego and the actors attached to it."""

    def __init__(self, world: Any, ego_id: int) -> None:
        self._world = world
        self._ego_id = ego_id
        self._boxes: dict[int, BridgeActorBox | None] = {}
        self._ids: frozenset[int] = frozenset()

    def refresh(self, snapshot: Any) -> dict[int, BridgeActorBox]:
        """Return the boxes of a snapshot's actors, by id."""
        ids = frozenset(actor.id for actor in snapshot)
        if ids != self._ids:
            for removed_id in self._boxes.keys() - ids:
                del self._boxes[removed_id]
            new_ids = list(ids - self._boxes.keys())
            listed = {actor.id: actor for actor in self._world.get_actors(new_ids)} if new_ids else {}
            self._boxes.update({i: self._box_of(actor) for i, actor in listed.items()})
            # Actors that the server does not list yet are requested again on the next tick.
            self._ids = ids - (frozenset(new_ids) - listed.keys())
        return {i: body for i, body in self._boxes.items() if body is not None}

    def near(self, x: float, y: float, range_m: float) -> list[PlacedBox]:
        """Return the boxes within a square of half size `range_m` around (x, y)."""
        snapshot = self._world.get_snapshot()
        nearby = []
        for actor_id, body in self.refresh(snapshot).items():
            actor = snapshot.find(actor_id)
            if actor is None:
                continue
            box = placed_box(body, actor)
            if abs(box.x - x) < range_m and abs(box.y - y) < range_m:
                nearby.append(box)
        return nearby

    def _box_of(self, actor: Any) -> BridgeActorBox | None:
        if actor.id == self._ego_id or actor.type_id.startswith(BODILESS):
            return None
        if actor.parent is not None and actor.parent.id == self._ego_id:
            return None
        return actor_box(actor)


def actor_box(actor: Any) -> BridgeActorBox:
    """Return the box of a `carla.Actor`. Old clients have boxes only for vehicles and walkers."""
    box = getattr(actor, "bounding_box", None)
    size = [UNKNOWN_SIZE_M] * 3
    offset = (0.0, 0.0, UNKNOWN_SIZE_M)
    yaw = 0.0
    if box is not None:
        extent = [float(box.extent.x), float(box.extent.y), float(box.extent.z)]
        if all(map(math.isfinite, extent)) and max(extent[0], extent[1]) > 0.0:
            size = extent
            place = (float(box.location.x), float(box.location.y), float(box.location.z))
            offset = place if all(map(math.isfinite, place)) else (0.0, 0.0, size[2])
            yaw = math.radians(box.rotation.yaw)
    return BridgeActorBox(actor, size[0], size[1], size[2], offset, yaw)


def placed_box(body: BridgeActorBox, actor: Any) -> PlacedBox:
    """Return a box at the pose of the snapshot's actor."""
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
