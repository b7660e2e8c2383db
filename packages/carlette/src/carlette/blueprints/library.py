"""The blueprint library: definitions for the client, models for the physics."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

from carlette.blueprints.default_color import COLOR, UNPAINTED
from carlette.blueprints.definitions import (
    Attribute,
    AttributeType,
    Definition,
    flag,
    integer,
    number,
    option,
    role_name,
    text,
)
from carlette.blueprints.sensor_definitions import sensor_definitions
from carlette.blueprints.tables import (
    PropModel,
    VehicleSpec,
    WalkerModel,
    animal_models,
    prop_models,
    vehicle_models,
    walker_models,
)

COLORS = ("255,255,255", "17,17,17", "88,88,88", "180,44,44", "22,62,120", "178,174,162")
BIKE_COLORS = ("0,0,0", "120,20,20", "30,70,140")
POLICE_COLORS = ("255,255,255",)
GESTURES = ("none", "stop", "go", "slow")
"""Signs of a flagger; `world.skeleton` contains the poses."""
EXTRA = "carlette_extra"
"""Tag and attribute of blueprints that CARLA does not have."""


@dataclass(frozen=True)
class Catalog:
    """All spawnable actors. The definitions have the order in which the client gets them."""

    definitions: dict[str, Definition]
    vehicles: dict[str, VehicleSpec] = field(default_factory=dict)
    props: dict[str, PropModel] = field(default_factory=dict)
    walkers: dict[str, WalkerModel] = field(default_factory=dict)
    """Pedestrians and animals: all actors that accept walker controls."""


@lru_cache(maxsize=1)
def load_catalog() -> Catalog:
    """Return the catalog. It is read once and is immutable."""
    vehicles = {model.id: model for model in vehicle_models()}
    props = {model.id: model for model in prop_models()}
    walkers = {model.id: model for model in walker_models()}
    animals = {model.id: model for model in animal_models()}
    # The order is CARLA's. Clients list the library by a hash table in which the order of arrival counts, so that a
    # program that draws a vehicle with a seed draws the same one.
    definitions = [
        *map(vehicle_definition, vehicles.values()),
        *sensor_definitions(),
        *map(walker_definition, walkers.values()),
        Definition("controller.ai.walker", (role_name("walker"),)),
        *map(prop_definition, props.values()),
        mesh_definition(),
        *map(animal_definition, animals.values()),
    ]
    return Catalog({definition.id: definition for definition in definitions}, vehicles, props, walkers | animals)


def vehicle_definition(model: VehicleSpec) -> Definition:
    """Return the blueprint of a vehicle."""
    colors = POLICE_COLORS if model.special_type == "emergency" else COLORS
    attributes: list[Attribute] = [
        text("base_type", model.base_type),
        text("special_type", model.special_type),
        integer("generation", model.generation),
        integer("number_of_wheels", model.wheels),
        flag("has_lights", model.has_lights),
        flag("has_dynamic_doors", model.has_doors),
        text("object_type", ""),
        role_name("autopilot", "autopilot", "scenario", "ego_vehicle"),
        option("sticky_control", AttributeType.BOOL, "True"),
        option("terramechanics", AttributeType.BOOL, "False"),
        _color(BIKE_COLORS if model.is_two_wheeler else colors),
    ]
    if model.is_two_wheeler:
        attributes.append(option("driver_id", AttributeType.INT, "0", "0", "1", "2"))
    return _definition(model.id, attributes, model.is_extra)


def walker_definition(model: WalkerModel) -> Definition:
    """Return the blueprint of a pedestrian."""
    attributes = [
        text("gender", model.gender),
        text("age", model.age),
        integer("generation", model.generation),
        role_name("pedestrian"),
        option("is_invincible", AttributeType.BOOL, "true"),
        flag("can_use_wheelchair", model.can_use_wheelchair),
        _speed(model),
    ]
    if model.can_use_wheelchair:
        attributes.append(option("use_wheelchair", AttributeType.BOOL, "false"))
    if model.is_extra:
        attributes.append(option("gesture", AttributeType.STRING, GESTURES[0], *GESTURES))
    return _definition(model.id, attributes, model.is_extra)


def animal_definition(model: WalkerModel) -> Definition:
    """Return the blueprint of an animal.

    Its id does not begin with `walker.`, so that programs that draw one of `walker.*` get people, as in CARLA.
    `carla.command.ApplyWalkerControl` moves it all the same.
    """
    attributes = [role_name("animal"), option("is_invincible", AttributeType.BOOL, "true"), _speed(model)]
    return _definition(model.id, attributes, model.is_extra)


def prop_definition(model: PropModel) -> Definition:
    """Return the blueprint of a static prop."""
    size_m = max(model.length_m, model.width_m, model.height_m)
    return _definition(model.id, [role_name("prop"), text("size", _size_class(size_m))], model.is_extra)


def mesh_definition() -> Definition:
    """Return a prop whose mesh the client names.

    carlette has no such meshes and shows a box with half sizes of half a meter.
    """
    return Definition(
        "static.prop.mesh",
        (
            role_name("prop"),
            option("mesh_path", AttributeType.STRING, ""),
            number("scale", 1.0, modifiable=True),
            number("mass", 0.0, modifiable=True),
        ),
    )


def _definition(id: str, attributes: list[Attribute], is_extra: bool) -> Definition:
    if is_extra:
        return Definition(id, (*attributes, flag(EXTRA, True)), (EXTRA,))
    return Definition(id, tuple(attributes))


def _speed(model: WalkerModel) -> Attribute:
    """Return the speeds of standing, walking and running (m/s), in the order that traffic generators expect."""
    walk, run = f"{model.walk_mps:g}", f"{model.run_mps:g}"
    return Attribute("speed", AttributeType.FLOAT, walk, ("0", walk, run), True)


def _color(values: tuple[str, ...]) -> Attribute:
    return Attribute(COLOR, AttributeType.COLOR, UNPAINTED, values, is_modifiable=True)


def _size_class(size_m: float) -> str:
    limits = ((0.3, "tiny"), (0.9, "small"), (2.0, "medium"))
    return next((name for limit_m, name in limits if size_m < limit_m), "big")
