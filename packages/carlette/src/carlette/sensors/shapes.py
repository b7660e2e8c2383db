"""The bodies of actors as rays hit them: the cameras' meshes, in the actor's frame, without lamps and shadows.

People's limbs do not swing here as they do in pictures.
"""

from __future__ import annotations

from functools import lru_cache

from carlette.blueprints import load_catalog
from carlette.camera.models.animals import animal_mesh
from carlette.camera.models.cycles import cycle_mesh
from carlette.camera.models.doors_and_stop_arm import door_mesh
from carlette.camera.models.mesh import EMPTY, Color, Mesh
from carlette.camera.models.people import clothes_of, person
from carlette.camera.models.props import prop_mesh
from carlette.camera.models.traffic_lights import post_mesh, repeater_mesh
from carlette.camera.models.vehicles import vehicle_mesh
from carlette.geometry import Box, Pose
from carlette.world.actor import Actor, ActorKind
from carlette.world.skeleton import Bone, bones

GRAY: Color = (128, 128, 128)
"""Any color: rays ignore it."""


def shape_of(actor: Actor) -> Mesh:
    """Return the surface of an actor; empty if it has no body."""
    if actor.kind is ActorKind.LIGHT:
        return _post(round(actor.box.center.x, 1))
    if actor.kind is ActorKind.WALKER and not actor.type_id.startswith("animal."):
        return _person(actor)
    return _shape(actor.type_id, actor.kind, actor.box)


@lru_cache(maxsize=256)
def door_shape(type_id: str, box: Box, door: int, swing: float) -> Mesh:
    """Return a door that is open by `swing` (0 to 1)."""
    return door_mesh(type_id, box, door, swing, GRAY)


@lru_cache(maxsize=512)
def _shape(type_id: str, kind: ActorKind, box: Box) -> Mesh:
    if kind is ActorKind.VEHICLE:
        model = load_catalog().vehicles[type_id]
        if model.is_two_wheeler:
            return cycle_mesh(type_id, box, model.wheelbase_m, GRAY, 0.0, motor=model.base_type == "motorcycle")
        return vehicle_mesh(type_id, box, model.wheelbase_m, GRAY)
    if kind is ActorKind.WALKER:
        return animal_mesh(type_id, box, 0.0, 0.0)
    return prop_mesh(type_id, box) if kind is ActorKind.PROP else EMPTY


def _person(actor: Actor) -> Mesh:
    half_height_m = actor.box.extent.z
    if not actor.posed:
        return _standing(actor.type_id, half_height_m)
    return _figure(actor.type_id, half_height_m, _joints(bones(Pose(), half_height_m, actor.posed, actor.blend)))


@lru_cache(maxsize=256)
def _standing(type_id: str, half_height_m: float) -> Mesh:
    return _figure(type_id, half_height_m, _joints(bones(Pose(), half_height_m)))


def _joints(found: list[Bone]) -> tuple[tuple[str, float, float, float], ...]:
    return tuple((item.name.removeprefix("crl_"), *item.component.location) for item in found)


@lru_cache(maxsize=256)
def _figure(type_id: str, half_height_m: float, joints: tuple[tuple[str, float, float, float], ...]) -> Mesh:
    model = load_catalog().walkers[type_id]
    places = {name: (x, y, z) for name, x, y, z in joints}
    return person(places, 2 * half_height_m, clothes_of(type_id, model.gender, model.age))


@lru_cache(maxsize=1024)
def second_post(x: float, y: float, z: float) -> Mesh:
    """Return a traffic light's second post with its foot at a position in the light's frame."""
    return repeater_mesh().placed(x, y, z, 0.0)


_post = lru_cache(maxsize=256)(post_mesh)
