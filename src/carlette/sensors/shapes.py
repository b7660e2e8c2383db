"""The bodies of actors as rays meet them: simple solids inside each actor's true bounding box.

Frame: the actor's. Vehicles have a hull, a cabin and wheels; people have legs, a trunk and a head.
"""

from __future__ import annotations

from functools import lru_cache

from carlette.blueprints import VehicleModel, load_catalogue
from carlette.camera import tags
from carlette.camera.mesh import EMPTY, Builder, Mesh
from carlette.geometry import Box
from carlette.world.actor import Actor, Kind

GREY = (128, 128, 128)
"""Rays see no colour."""
LIGHT_POLE_M, LIGHT_POLE_RADIUS_M = 5.2, 0.1
CONES = ("constructioncone", "trafficcone01", "trafficcone02")
ROUND = ("barrel", "bin", "trashcan", "plantpot", "fountain", "gnome", "ball", "colacan", "wateringcan")


def shape_of(actor: Actor) -> Mesh:
    """The solids of an actor; none for what has no body."""
    if actor.kind is Kind.LIGHT:
        return _light()
    tag = actor.tags[0] if actor.tags else tags.STATIC
    return _shape(actor.type_id, actor.kind, actor.box, tag)


@lru_cache(maxsize=512)
def _shape(type_id: str, kind: Kind, box: Box, tag: int) -> Mesh:
    if kind is Kind.VEHICLE:
        model = load_catalogue().vehicles[type_id]
        return _two_wheeler(model, tag) if model.is_two_wheeler else _vehicle(model, tag)
    if kind is Kind.WALKER:
        return _animal(box, tag) if type_id.startswith("animal.") else _person(box, tag)
    if kind is Kind.PROP:
        return _prop(type_id, box, tag)
    return EMPTY


def _vehicle(model: VehicleModel, tag: int) -> Mesh:
    builder = Builder(tag)
    (x, y, z), (hx, hy, hz) = model.box.center, model.box.extent
    low, high = z - hz, z + hz
    clearance, waist = low + 0.14 * 2 * hz, low + 0.56 * 2 * hz
    if model.base_type == "car":
        builder.box((x, y, (clearance + waist) / 2), (2 * hx, 2 * hy, waist - clearance), GREY)
        foot = [(x + a * hx, y + b * hy * 0.9, waist) for a, b in ((0.42, 1), (0.42, -1), (-0.86, -1), (-0.86, 1))]
        roof = [(x + a * hx, y + b * hy * 0.74, high) for a, b in ((0.08, 1), (0.08, -1), (-0.6, -1), (-0.6, 1))]
        builder.hull(foot, roof, GREY)
    else:
        builder.box((x, y, (clearance + high) / 2), (2 * hx, 2 * hy, high - clearance), GREY)
    radius = min(0.5, 0.22 * 2 * hz) if model.base_type == "car" else min(0.52, 0.16 * 2 * hz)
    for along in (model.wheelbase_m / 2, -model.wheelbase_m / 2):
        for side in (-1.0, 1.0):
            outer = y + side * hy * 0.98
            builder.cylinder((along, outer - side * 0.24, low + radius), (along, outer, low + radius), radius, GREY)
    return builder.mesh()


def _two_wheeler(model: VehicleModel, tag: int) -> Mesh:
    builder = Builder(tag)
    (x, y, z), (hx, hy, hz) = model.box.center, model.box.extent
    low = z - hz
    radius = min(0.36, 0.45 * hz, hx - model.wheelbase_m / 2)
    for along in (model.wheelbase_m / 2, -model.wheelbase_m / 2):
        builder.cylinder((x + along, y - 0.04, low + radius), (x + along, y + 0.04, low + radius), radius, GREY)
    builder.box((x, y, low + 0.62 * hz), (model.wheelbase_m, 0.14, 0.5 * hz), GREY)
    builder.box((x + 0.35 * hx, y, low + 1.1 * hz), (0.12, 1.96 * hy, 0.08), GREY)
    builder.tag = tags.RIDER
    builder.box((x - 0.1 * hx, y, low + 1.3 * hz), (0.3, min(0.44, 1.8 * hy), 0.78 * hz), GREY)
    builder.box((x, y, low + 1.84 * hz), (0.22, 0.2, 0.3 * hz), GREY)
    for side in (-1.0, 1.0):
        builder.box((x + 0.1 * hx, y + side * 0.13, low + 0.72 * hz), (0.18, 0.13, 0.8 * hz), GREY)
    return builder.mesh()


def _person(box: Box, tag: int) -> Mesh:
    builder = Builder(tag)
    (x, y, z), (hx, hy, hz) = box.center, box.extent
    low = z - hz
    for side in (-1.0, 1.0):
        builder.box((x, y + side * 0.42 * hy, low + 0.47 * hz), (0.8 * hx, 0.7 * hy, 0.94 * hz), GREY)
    builder.box((x, y, low + 1.31 * hz), (1.2 * hx, 2.0 * hy, 0.74 * hz), GREY)
    builder.cylinder((x, y, low + 1.68 * hz), (x, y, low + 2.0 * hz), min(0.12, 0.6 * hx), GREY)
    return builder.mesh()


def _animal(box: Box, tag: int) -> Mesh:
    builder = Builder(tag)
    (x, y, z), (hx, hy, hz) = box.center, box.extent
    low = z - hz
    builder.box((x - 0.1 * hx, y, low + 1.2 * hz), (1.6 * hx, 2 * hy, 0.7 * hz), GREY)
    builder.box((x + 0.8 * hx, y, low + 1.7 * hz), (0.4 * hx, hy, 0.6 * hz), GREY)
    for a in (-0.75, 0.55):
        for side in (-1.0, 1.0):
            builder.box((x + a * hx, y + side * 0.7 * hy, low + 0.45 * hz), (0.16 * hx, 0.4 * hy, 0.9 * hz), GREY)
    return builder.mesh()


def _prop(type_id: str, box: Box, tag: int) -> Mesh:
    builder = Builder(tag)
    (x, y, z), (hx, hy, hz) = box.center, box.extent
    name = type_id.rsplit(".", 1)[-1]
    low, radius = z - hz, min(hx, hy)
    if name in CONES:
        builder.box((x, y, low + 0.05 * hz), (2 * hx, 2 * hy, 0.1 * hz), GREY)
        builder.cylinder((x, y, low + 0.1 * hz), (x, y, low + 2 * hz), 0.75 * radius, GREY, tip=0.15 * radius)
    elif name.startswith(ROUND):
        builder.cylinder((x, y, low), (x, y, low + 2 * hz), radius, GREY, sides=12)
    else:
        builder.box((x, y, z), (2 * hx, 2 * hy, 2 * hz), GREY)
    return builder.mesh()


@lru_cache(maxsize=1)
def _light() -> Mesh:
    """A pole with the lamps at its top; the actor's origin lies on the ground."""
    builder = Builder(tags.POLE)
    builder.cylinder((0.0, 0.0, 0.0), (0.0, 0.0, LIGHT_POLE_M), LIGHT_POLE_RADIUS_M, GREY)
    builder.tag = tags.TRAFFIC_LIGHT
    builder.box((0.0, 0.0, LIGHT_POLE_M - 0.5), (0.4, 0.4, 1.0), GREY)
    return builder.mesh()
