"""The world as sensors measure it. Values that several sensors use on one tick are computed once."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from carlette.camera.environment.repeater_lights import repeaters_of
from carlette.camera.models.mesh import Mesh, Point
from carlette.geometry import Floats, Pose
from carlette.sensors.ray_surfaces import Indices, RaySurfaces, Singles, faces_of, static_faces
from carlette.sensors.rotations import axes, many_axes
from carlette.sensors.shapes import door_shape, second_post, shape_of
from carlette.world.actor import Actor, ActorKind
from carlette.world.world import World

SWING_STEPS = 12
"""Number of steps of a door's swing for which meshes are cached. Ours."""
SHOWN = (ActorKind.VEHICLE, ActorKind.WALKER, ActorKind.PROP, ActorKind.LIGHT)


class RaySweep(NamedTuple):
    """Hits of a fan of rays."""

    nearness: Singles
    """(columns, channels): inverse of the distance (1/m)."""
    hit: NDArray[np.int32]
    """(columns, channels): index of the face; -1 = none."""
    gaps: Singles
    """(faces,): distance from the sensor to the plane of each face that was hit (m)."""


class BodyPoses(NamedTuple):
    """The bodies of all actors at one moment. They never change."""

    actors: list[Actor]
    faces: RaySurfaces
    body_of: Indices
    """Index in `actors` of each face."""


class ActorSurfaces:
    """The bodies of the actors of one world. They are rebuilt when an actor is added, removed, or opens a door."""

    def __init__(self) -> None:
        self._meshes: list[Mesh] = []
        self._faces = faces_of([])
        self._body_of = self._faces.body_of

    def update(self, world: World) -> BodyPoses:
        """Return the bodies of the actors that are in the world now."""
        doors = _doors(world)
        far = repeaters_of(world.roads)
        shown = [
            (item, mesh) for item in world.actors.values() if item.kind in SHOWN for mesh in _meshes(item, doors, far)
        ]
        meshes = [mesh for _, mesh in shown]
        if len(meshes) != len(self._meshes) or any(a is not b for a, b in zip(meshes, self._meshes, strict=True)):
            self._meshes, self._faces = meshes, faces_of(meshes)
            self._body_of = self._faces.body_of
        return BodyPoses([actor for actor, _ in shown], self._faces, self._body_of)


class SensorScene:
    """One frame of one world; created for each tick on which a sensor is due."""

    def __init__(self, world: World, cast: ActorSurfaces | None = None) -> None:
        self.world = world
        self._cast = cast or ActorSurfaces()

    def hold(self) -> None:
        """Copy the state of the actors that rays use. After that the world may change."""
        _ = (self.cast, self.places, self.turns, self._speeds)

    @cached_property
    def static(self) -> RaySurfaces:
        """The static faces, in the world frame."""
        return static_faces(self.world.roads)

    @cached_property
    def cast(self) -> BodyPoses:
        """The actors' bodies."""
        return self._cast.update(self.world)

    @cached_property
    def places(self) -> Floats:
        """Positions of the bodies of `cast`, (b, 3)."""
        return self.world.bodies.position[[actor.row for actor in self.cast.actors]].reshape(-1, 3)

    @cached_property
    def turns(self) -> Floats:
        """Rotations of the bodies, (b, 3, 3): from their frames to the world frame."""
        return many_axes(self.world.bodies.rotation[[actor.row for actor in self.cast.actors]].reshape(-1, 3))

    def sweep(self, pose: Pose, azimuths: Floats, tangents: Floats, reach_m: float) -> RaySweep:
        """Cast a ray for each azimuth (rad, ascending, -π to π) and each tangent of an elevation (ascending).

        `tangents` is (1, k), or (m, k) if each azimuth has its own. Angles are in the sensor's frame.
        """
        from carlette.sensors.kernels import scan  # the first such sensor loads numba

        shape = (len(azimuths), tangents.shape[1])
        result = RaySweep(
            np.full(shape, 1.0 / max(reach_m, 1e-6), np.float32),
            np.full(shape, -1, np.int32),
            np.empty(len(self.static.tags) + len(self.cast.faces.tags), np.float32),
        )
        origin, frame = np.array(pose.location), axes(pose.rotation)
        near = self._near(self.static, origin, self.static.centers, reach_m)
        still = (np.broadcast_to(frame.T, (len(near), 3, 3)), np.broadcast_to(-frame.T @ origin, (len(near), 3)))
        moving = self.cast.faces
        middles = self.places + np.einsum("bij,bj->bi", self.turns, moving.centers)
        there = self._near(moving, origin, middles, reach_m)
        turned = (frame.T @ self.turns[there], (self.places[there] - origin) @ frame)
        for faces, which, (turns, shifts), base in (
            (self.static, near, still, 0),
            (moving, there, turned, len(self.static.corners)),
        ):
            scan(
                faces.corners,
                faces.spans[which],
                np.ascontiguousarray(turns, float),
                np.ascontiguousarray(shifts, float),
                azimuths,
                tangents,
                reach_m,
                base,
                *result,
            )
        return result

    @staticmethod
    def _near(faces: RaySurfaces, origin: Floats, centers: Floats, reach_m: float) -> Indices:
        gaps = np.linalg.norm(centers - origin, axis=1) - faces.radii
        order = np.argsort(gaps)
        nearest: Indices = order[gaps[order] < reach_m]
        return nearest

    @cached_property
    def face_tags(self) -> NDArray[np.uint32]:
        """Semantic tag of each face in `RaySweep.hit` (`CityObjectLabel`)."""
        own = np.array([actor.tags[0] if actor.tags else 0 for actor in self.cast.actors], np.uint8)[self.cast.body_of]
        faces = self.cast.faces.tags
        return np.concatenate([self.static.tags, np.where(faces > 0, faces, own)]).astype(np.uint32)

    @cached_property
    def face_actors(self) -> NDArray[np.uint32]:
        """Id of the actor of each face; 0 = none."""
        ids = np.array([actor.id for actor in self.cast.actors], np.uint32)
        return np.concatenate([np.zeros(len(self.static.tags), np.uint32), ids[self.cast.body_of]])

    def velocities(self, faces: NDArray[np.int32]) -> Floats:
        """Return the velocities of the actors whose faces were hit, (n, 3) (m/s, world frame)."""
        found = np.zeros((len(faces), 3))
        moving = faces >= len(self.static.tags)
        found[moving] = self._speeds[self.cast.body_of[faces[moving] - len(self.static.tags)]]
        return found

    @cached_property
    def _speeds(self) -> Floats:
        return self.world.bodies.velocity[[actor.row for actor in self.cast.actors]].reshape(-1, 3)


def _meshes(actor: Actor, doors: dict[int, list[tuple[int, float]]], far: list[Point | None]) -> list[Mesh]:
    """Return an actor's body and its open doors; for a traffic light also the second post."""
    if actor.kind is ActorKind.LIGHT:
        foot = far[actor.index]
        return [shape_of(actor), *([] if foot is None else [second_post(*foot)])]
    opened = [door_shape(actor.type_id, actor.box, *door) for door in doors.get(actor.row, [])]
    return [mesh for mesh in (shape_of(actor), *opened) if len(mesh)]


def _doors(world: World) -> dict[int, list[tuple[int, float]]]:
    """Return doors that are not closed by the row of their vehicle: number, and swing (0 to 1) in cached steps."""
    found: dict[int, list[tuple[int, float]]] = {}
    table = world.doors
    for row, door, swing in zip(table.row.tolist(), table.door.tolist(), table.swing.tolist(), strict=True):
        found.setdefault(row, []).append((door, round(swing * SWING_STEPS) / SWING_STEPS))
    return found
