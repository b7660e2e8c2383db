"""Blueprints, and the spawning, destruction and lookup of actors."""

from __future__ import annotations

from typing import Any

from carlette.blueprints import load_catalog
from carlette.blueprints.sensor_definitions import IN_THE_CLIENT
from carlette.errors import RequestError
from carlette.geometry import Box, Vector
from carlette.rpc.registry import Methods
from carlette.rpc.session import ClientSession
from carlette.sensors import make_sensor
from carlette.wire import encode
from carlette.world.actor import Actor
from carlette.world.spawn import spawn

methods = Methods()

MOST_TEXT = 20_000
"""Maximum number of characters of all of an actor's attributes together. Ours; a color camera has 1,000."""


@methods.value("get_actor_definitions")
def get_actor_definitions(session: ClientSession) -> Any:
    simulator = session.simulator
    definitions = load_catalog().definitions
    return [
        encode.definition(simulator.uids[definition.id], definition, simulator.version)
        for definition in definitions.values()
    ]


@methods.value("get_spectator")
def get_spectator(session: ClientSession) -> Any:
    return session.wire(session.world.spectator)


@methods.value("get_actors_by_id")
def get_actors_by_id(session: ClientSession, ids: list[int]) -> Any:
    actors = session.world.actors
    return [session.wire(actors[object_id]) for object_id in dict.fromkeys(ids) if object_id in actors]


@methods.value("spawn_actor")
def spawn_actor(session: ClientSession, description: list[Any], transform: list[Any]) -> Any:
    return session.wire(bring_in(session, description, transform))


@methods.value("spawn_actor_with_parent")
def spawn_actor_with_parent(
    session: ClientSession,
    description: list[Any],
    transform: list[Any],
    parent: int,
    attachment: int = 0,
    socket: str = "",
) -> Any:
    del attachment, socket  # all attachments are rigid
    return session.wire(bring_in(session, description, transform, parent))


def bring_in(session: ClientSession, description: list[Any], transform: list[Any], parent: int = 0) -> Actor:
    """Spawn the actor that a request describes."""
    type_id, attributes = description[1], encode.read_attributes(description[2], session.simulator.version)
    if sum(len(name) + len(text) for name, (_, text) in attributes.items()) > MOST_TEXT:
        raise RequestError(f"Spawn of '{type_id}' refused: its attributes have more than {MOST_TEXT:,} characters")
    if type_id.startswith("sensor.") and type_id not in IN_THE_CLIENT:
        # Reject a sensor that cannot be created before its actor exists.
        scenery = make_sensor(type_id, attributes).load(session.world)
        if scenery is not None and scenery not in session.simulator.sceneries:
            session.simulator.sceneries.append(scenery)
    return spawn(session.world, type_id, attributes, encode.read_pose(transform), parent)


@methods.value("destroy_actor")
def destroy_actor(session: ClientSession, actor_id: int) -> bool:
    actor = session.world.actors.get(actor_id)
    if actor is not None and (actor is session.world.spectator or actor.type_id.startswith("traffic.")):
        raise RequestError(
            f"destroy_actor: actor {actor_id} ({actor.type_id}) is part of the map and cannot be destroyed"
        )
    if actor is not None and actor.stream_id:
        session.simulator.parting = session.simulator.hub.parting(session.simulator.stream_of(actor))
    return session.world.remove(actor_id)


@methods.value("get_actor_bounding_box")
def get_actor_bounding_box(session: ClientSession, actor_id: int) -> Any:
    """Return an actor's box; for an actor that no longer exists, a box without size.

    The traffic manager of 0.9.16 calls this in a thread in which an error would end the client's process.
    """
    actor = session.world.actors.get(actor_id)
    return encode.box(actor.box if actor else Box(Vector(), Vector()))


@methods.value("get_actor_component_names", "get_actor_bone_names", "get_actor_socket_names")
def no_names(session: ClientSession, actor_id: int) -> list[str]:
    session.actor(actor_id, "get_actor_component_names")
    return []


@methods.value(
    "get_actor_bone_world_transforms",
    "get_actor_bone_relative_transforms",
    "get_actor_socket_world_transforms",
    "get_actor_socket_relative_transforms",
    "get_vehicle_bone_world_transforms",
)
def no_transforms(session: ClientSession, actor_id: int) -> list[Any]:
    session.actor(actor_id, "get_actor_bone_world_transforms")
    return []


@methods.value("get_actor_component_world_transform", "get_actor_component_relative_transform")
def component_transform(session: ClientSession, actor_id: int, name: str) -> Any:
    session.actor(actor_id, "get_actor_component_world_transform")
    raise RequestError(f"actor {actor_id} has no component '{name}'; this server's actors are boxes")


@methods.void("send")
def send(session: ClientSession, actor_id: int, message: str) -> None:
    del message  # V2X arrives with the sensors
    session.actor(actor_id, "send")
