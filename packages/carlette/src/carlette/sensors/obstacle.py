"""The obstacle detector: a sphere that is swept ahead of the sensor until it touches something."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future
from typing import Any, NamedTuple

import msgpack
import numpy as np

from carlette.camera.rendering import tags
from carlette.geometry import Floats
from carlette.sensors.ray_surfaces import RaySurfaces
from carlette.sensors.rotations import axes
from carlette.sensors.sensor import Body, LateSensor, SensorAttributes, SensorTick
from carlette.sensors.sensor_scene import SensorScene
from carlette.sensors.workers import build_faces, caster
from carlette.world.actor import Actor, ActorKind
from carlette.world.world import World

TOUCH_M = 1e-3
"""Gap at which the sphere counts as touching (m). Ours."""
MOST_STEPS = 500
"""Maximum number of steps of the sphere. Ours."""
MOST_REACH_M = 2000.0
"""Largest distance and radius that a client may set (m). Ours."""
DYNAMIC = (ActorKind.VEHICLE, ActorKind.WALKER)
SOLID = (ActorKind.VEHICLE, ActorKind.WALKER, ActorKind.PROP)
_GROUND = (tags.ROAD, tags.SIDEWALK, tags.TERRAIN, tags.GROUND, tags.ROAD_LINE)
_NAMES = {tags.BUILDING: "building", tags.VEGETATION: "vegetation", tags.POLE: "pole", tags.TRAFFIC_SIGN: "trafficsign"}


class ObstacleHit(NamedTuple):
    """The first object in the path of the sphere."""

    distance_m: float
    other: Any
    """An actor in the client's form."""


class ObstacleSensor(LateSensor):
    """Reports, on each tick, the first obstacle ahead: an actor's bounding box, or scenery; never the ground."""

    wire_type = 7

    def __init__(self, settings: SensorAttributes) -> None:
        super().__init__(settings)
        self._reach_m = settings.number("distance", 0.0, MOST_REACH_M)
        self._radius_m = settings.number("hit_radius", 0.0, MOST_REACH_M)
        self._kinds = DYNAMIC if settings.flag("only_dynamics") else SOLID
        self._sees_scenery = not settings.flag("only_dynamics")
        settings.flag("debug_linetrace")

    def load(self, world: World) -> Future[None]:
        return build_faces(world.roads)

    def begin(self, moment: SensorTick) -> Future[list[Body]]:
        finder = moment.scene.world.actors.get(moment.actor.parent_id, moment.actor)
        origin, ahead = np.array(moment.pose.location), axes(moment.pose.rotation)[:, 0]
        among = list(self._among_actors(moment, origin, ahead))
        described = moment.wire(finder)
        return caster().submit(lambda: self._reported(described, among, moment.scene, (origin, ahead)))

    def _reported(
        self, finder: Any, among: list[ObstacleHit], scene: SensorScene, ray: tuple[Floats, Floats]
    ) -> list[Body]:
        found = [*among, *self._in_scenery(scene, *ray)]
        if not found:
            return []
        first = min(found, key=lambda item: item.distance_m)
        return [(msgpack.packb([finder, first.other, first.distance_m], unicode_errors="surrogateescape"),)]

    def _among_actors(self, moment: SensorTick, origin: Floats, ahead: Floats) -> Iterator[ObstacleHit]:
        world = moment.scene.world
        excluded_ids = (moment.actor.id, moment.actor.parent_id)
        others = [
            actor for actor in world.actors.values() if actor.kind in self._kinds and actor.id not in excluded_ids
        ]
        places = world.bodies.position[[other.row for other in others]].reshape(-1, 3)
        sizes = np.array([np.linalg.norm(other.box.center) + np.linalg.norm(other.box.extent) for other in others])
        near = np.linalg.norm(places - origin, axis=1) < self._reach_m + self._radius_m + sizes
        others = [other for other, is_near in zip(others, near.tolist(), strict=True) if is_near]
        if others:
            index, distance = _push(_Boxes(moment, others), origin, ahead, self._radius_m, self._reach_m)
            if index >= 0:
                yield ObstacleHit(distance, moment.wire(others[index]))

    def _in_scenery(self, scene: SensorScene, origin: Floats, ahead: Floats) -> Iterator[ObstacleHit]:
        if not self._sees_scenery:
            return
        faces = scene.static
        which = _near_quads(faces, origin, self._reach_m + self._radius_m)
        if len(which):
            quads = faces.corners[which].astype(float)
            index, distance = _push(_Quads(quads), origin, ahead, self._radius_m, self._reach_m)
            if index >= 0:
                tag = int(faces.tags[which[index]])
                described = [0, f"static.{_NAMES.get(tag, 'unknown')}", []]
                flat = [0.0, 0.0, 0.0]
                yield ObstacleHit(distance, [0, 0, described, [flat, flat, flat], bytes([tag]), b""])


class _Boxes:
    """The bounding boxes of some actors."""

    def __init__(self, moment: SensorTick, actors: list[Actor]) -> None:
        world = moment.scene.world
        poses = [world.pose(actor) for actor in actors]
        self._middles = np.array([pose.apply(item.box.center) for pose, item in zip(poses, actors, strict=True)])
        self._axes = np.array([axes(pose.rotation) for pose in poses])
        self._halves = np.array([actor.box.extent for actor in actors])

    def distances(self, point: Floats) -> Floats:
        """Return the distance of a point from each box (m); 0 inside."""
        local = np.einsum("bji,bj->bi", self._axes, point - self._middles)
        gaps: Floats = np.linalg.norm(np.maximum(np.abs(local) - self._halves, 0.0), axis=1)
        return gaps


class _Quads:
    """Flat convex quads."""

    def __init__(self, corners: Floats) -> None:
        self._corners = corners
        normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        self._normals = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        self._edges = np.roll(corners, -1, axis=1) - corners
        self._squares = np.maximum((self._edges**2).sum(axis=2), 1e-12)

    def distances(self, point: Floats) -> Floats:
        """Return the distance of a point from each quad (m)."""
        gaps = point - self._corners
        along = np.clip((gaps * self._edges).sum(axis=2) / self._squares, 0.0, 1.0)
        to_edge = np.linalg.norm(gaps - along[..., None] * self._edges, axis=2).min(axis=1)
        side = (np.cross(self._edges, gaps) * self._normals[:, None, :]).sum(axis=2)
        above = np.abs((gaps[:, 0] * self._normals).sum(axis=1))
        nearest: Floats = np.where((side >= -1e-9).all(axis=1), above, to_edge)
        return nearest


def _near_quads(faces: RaySurfaces, origin: Floats, reach_m: float) -> Any:
    """Return the quads within reach that are not ground."""
    bodies = np.flatnonzero(np.linalg.norm(faces.centers - origin, axis=1) < reach_m + faces.radii)
    which = np.concatenate([np.arange(*faces.spans[body]) for body in bodies] or [np.zeros(0, np.int64)])
    which = which[~np.isin(faces.tags[which], _GROUND)]
    middles = faces.corners[which].mean(axis=1)
    sizes = np.linalg.norm(faces.corners[which] - middles[:, None, :], axis=2).max(axis=1, initial=0.0)
    return which[np.linalg.norm(middles - origin, axis=1) < reach_m + sizes]


def _push(things: _Boxes | _Quads, start: Floats, way: Floats, radius_m: float, reach_m: float) -> tuple[int, float]:
    """Return the index of the first obstacle that a sphere hits (-1 for none) and its distance (m).

    No obstacle is nearer than the smallest gap, so the sphere can always advance by that gap.
    """
    distance = 0.0
    for _ in range(MOST_STEPS):
        gaps = things.distances(start + distance * way)
        nearest = int(gaps.argmin())
        gap = float(gaps[nearest]) - radius_m
        if gap <= TOUCH_M:
            return nearest, distance
        distance += gap
        if distance > reach_m:
            break
    return -1, reach_m
