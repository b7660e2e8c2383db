"""Spawns actors at a client's request, and checks the space for them."""

from __future__ import annotations

from carlette.blueprints import Catalog, load_catalog
from carlette.blueprints.default_color import painted
from carlette.blueprints.sensor_definitions import IN_THE_CLIENT
from carlette.errors import RequestError, SpawnCollisionError
from carlette.geometry import Box, Pose, Vector
from carlette.physics.bodies import BodyTable
from carlette.physics.contacts import is_free
from carlette.physics.vehicle_parameters import parameters_of
from carlette.world.actor import Actor, ActorKind, Attributes
from carlette.world.skeleton import gesture
from carlette.world.speed_limits import pass_signs
from carlette.world.world import World

MOST_ACTORS = 4096
"""Maximum number of actors of a world, lights and signs included. Ours.

Each costs some microseconds per tick and 119 bytes per snapshot.
"""
VEHICLE_CLEARANCE_M = 0.15
"""Height of objects that a car drives over without touching them (m). Ours."""
CAR_TAG, TRUCK_TAG, BUS_TAG, MOTORCYCLE_TAG, BICYCLE_TAG, PEDESTRIAN_TAG, PROP_TAG = 14, 15, 16, 18, 19, 12, 21
"""Semantic tags of CARLA."""
_VEHICLE_TAGS = {"truck": TRUCK_TAG, "bus": BUS_TAG, "motorcycle": MOTORCYCLE_TAG, "bicycle": BICYCLE_TAG}


def spawn(world: World, type_id: str, attributes: Attributes, pose: Pose, parent_id: int = 0) -> Actor:
    """Add an actor as a client requested it.

    `pose` is in the world frame, or in the parent's frame if there is a parent.

    Raises:
        SpawnCollisionError: The space is taken.
        RequestError: The kind, the pose or the parent is not valid.
    """
    catalog = load_catalog()
    if type_id not in catalog.definitions:
        raise RequestError(_unknown_type(type_id))
    if len(world.actors) >= MOST_ACTORS:
        raise RequestError(f"Spawn of '{type_id}' refused: the world has {MOST_ACTORS:,} actors; destroy some first")
    if not pose.is_finite():
        raise RequestError(f"Spawn of '{type_id}' refused: the transform is not finite; give real coordinates")
    attached = None
    if parent_id:
        parent = world.actor(parent_id, "spawn_actor_with_parent")
        attached, pose = pose, world.pose(parent).compose(pose)
    actor = _enter(world, catalog, type_id, attributes, pose)
    actor.parent_id, actor.attached = parent_id, attached
    if parent_id:
        world.bodies.solid[actor.row] = actor.touches = False  # otherwise it would push its own carrier
    return actor


def _unknown_type(type_id: str) -> str:
    if type_id.startswith("sensor."):
        return (
            f"Sensor '{type_id}' is not simulated by this server; use one of get_blueprint_library().filter('sensor.*')"
        )
    return f"Unknown actor type '{type_id}'; use one of the blueprint library"


def _enter(world: World, catalog: Catalog, type_id: str, attributes: Attributes, pose: Pose) -> Actor:
    if type_id in catalog.vehicles:
        return _enter_vehicle(world, catalog, type_id, attributes, pose)
    if type_id in catalog.walkers:
        return _enter_walker(world, catalog, type_id, attributes, pose)
    if type_id in catalog.props or type_id == "static.prop.mesh":
        return _enter_prop(world, catalog, type_id, attributes, pose)
    kind = ActorKind.SENSOR if type_id.startswith("sensor.") else ActorKind.OTHER
    actor = world.enter(type_id, kind, pose, Box(Vector(), Vector()), attributes)
    actor.stream_id = actor.id if kind is ActorKind.SENSOR and type_id not in IN_THE_CLIENT else 0
    return actor


def _enter_vehicle(world: World, catalog: Catalog, type_id: str, attributes: Attributes, pose: Pose) -> Actor:
    model = catalog.vehicles[type_id]
    _require_free(world, pose, model.box, VEHICLE_CLEARANCE_M)
    chosen = painted(catalog.definitions[type_id], attributes, world.next_id)
    actor = world.enter(type_id, ActorKind.VEHICLE, pose, model.box, chosen)
    actor.tags = bytes([_VEHICLE_TAGS.get(model.base_type, CAR_TAG)])
    _make_solid(world, actor, model.mass_kg, VEHICLE_CLEARANCE_M)
    actor.physics = parameters_of(model)
    actor.index = world.fleet.add(actor.row, model, actor.physics)
    actor.surface = world.surface.add(actor.row, 0.0, tilts=True)
    world.fleet.sticky[actor.index] = _flag(attributes, "sticky_control", True)
    world.surface.update(world.bodies, world.roads)
    pass_signs(world.bodies, world.fleet, world.roads.speed_boxes)
    return actor


def _flag(attributes: Attributes, name: str, default: bool) -> bool:
    return attributes[name][1].lower() == "true" if name in attributes else default


def _enter_walker(world: World, catalog: Catalog, type_id: str, attributes: Attributes, pose: Pose) -> Actor:
    model = catalog.walkers[type_id]
    _require_free(world, pose, model.box, 0.0)
    actor = world.enter(type_id, ActorKind.WALKER, pose, model.box, attributes)
    actor.tags = bytes([PEDESTRIAN_TAG])
    _make_solid(world, actor, model.mass_kg, 0.0)
    mortal = _flag(attributes, "is_invincible", True) is False
    actor.index = world.walkers.append(row=actor.row, mortal=mortal)
    if "gesture" in attributes:
        actor.posed, actor.blend = gesture(attributes["gesture"][1], model.box.extent.z), 1.0
    actor.surface = world.surface.add(actor.row, model.box.extent.z, tilts=False, on_foot=True)
    return actor


def _enter_prop(world: World, catalog: Catalog, type_id: str, attributes: Attributes, pose: Pose) -> Actor:
    model = catalog.props.get(type_id)
    box = model.box if model else _mesh_box(attributes)
    actor = world.enter(type_id, ActorKind.PROP, pose, box, attributes)
    world.turn_prop(actor)
    actor.tags = bytes([PROP_TAG])
    movable = model is not None and model.contact == "loose"
    if model is None or model.contact != "passable":
        _make_solid(world, actor, model.mass_kg if model and movable else 0.0, 0.0)
    if movable:
        actor.index = world.props.append(row=actor.row)
        actor.surface = world.surface.add(actor.row, 0.0, tilts=False)
    return actor


def _mesh_box(attributes: Attributes) -> Box:
    """Return a box of half a meter each way, times the scale: this server has no such meshes."""
    try:
        scale = float(attributes["scale"][1])
    except (KeyError, ValueError):
        # An attribute that is missing or no number leaves the size unscaled.
        scale = 1.0
    half = 0.25 * scale if 0.0 < scale < 1000.0 else 0.25
    return Box(Vector(z=half), Vector(half, half, half))


def _make_solid(world: World, actor: Actor, mass_kg: float, clearance_m: float) -> None:
    bodies = world.bodies
    bodies.mass[actor.row] = mass_kg
    bodies.clearance[actor.row] = clearance_m
    bodies.solid[actor.row] = actor.touches = True
    bodies.simulated[actor.row] = mass_kg > 0


def _require_free(world: World, pose: Pose, box: Box, clearance_m: float) -> None:
    candidate = BodyTable()
    candidate.append(
        position=pose.location, rotation=pose.rotation, center=box.center, extent=box.extent, clearance=clearance_m
    )
    if not is_free(world.bodies, candidate, world.doors):
        raise SpawnCollisionError
