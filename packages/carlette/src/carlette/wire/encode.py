"""Values of the server as the arrays that the client expects (see the protocol's composite types)."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

import msgpack

from carlette.blueprints import Attribute, AttributeType, Definition
from carlette.client_versions import ClientVersion
from carlette.geometry import Box, Pose, Rotation, Vector

_TOKEN = struct.Struct("<IHBB16x")
_TCP = 1
"""Protocol number of TCP in a stream token."""
_SAME_HOST = 0
"""Address type of a token without an address: the client uses the host of its connection."""

WORLD_STREAM = 1
"""Stream of world snapshots, as in CARLA."""


def stream_token(stream_id: int, port: int) -> bytes:
    """Return a token that sends the client to `port` of the host that it already uses."""
    return _TOKEN.pack(stream_id, port, _TCP, _SAME_HOST)


def collision(actor: Any, other: Any, impulse: Vector) -> bytes:
    """Return a `CollisionEvent`: two actors in the client's form, and the impulse on the first (N·s)."""
    packed: bytes = msgpack.packb([actor, other, list(impulse)], unicode_errors="surrogateescape")
    return packed


Wire = Any
"""Anything that msgpack can pack. Only the client's compiled library has its types."""


def value(result: Wire) -> Wire:
    """Return a `Response<T>` with a value."""
    return [[1, result]]


def failure(message: str) -> Wire:
    """Return a `Response<T>` with an error, where T is not void."""
    return [[0, [message]]]


def done() -> Wire:
    """Return a `Response<void>` of a success."""
    return [[False]]


def void_failure(message: str) -> Wire:
    """Return a `Response<void>` with an error."""
    return [[True, [message]]]


def pose(value: Pose) -> Wire:
    """Return a `Transform`."""
    return [list(value.location), list(value.rotation)]


def box(value: Box) -> Wire:
    """Return a `BoundingBox`."""
    return [list(value.center), list(value.extent), list(value.rotation)]


def definition(uid: int, item: Definition, version: ClientVersion) -> Wire:
    """Return an `ActorDefinition`."""
    return [uid, item.id, item.tags, [_attribute(attribute, version) for attribute in item.attributes]]


def _attribute(item: Attribute, version: ClientVersion) -> Wire:
    kind = item.type + version.attribute_type_offset
    return [item.id, kind, item.value, list(item.recommended), item.is_modifiable, item.is_restricted]


def description(uid: int, type_id: str, attributes: Sequence[tuple[str, int, str]], version: ClientVersion) -> Wire:
    """Return an `ActorDescription`; the types in `attributes` are `AttributeType` numbers."""
    offset = version.attribute_type_offset
    return [uid, type_id, [[name, kind + offset, text] for name, kind, text in attributes]]


def read_vector(wire: Sequence[float]) -> Vector:
    """Return a `Vector3D` or `Location` of a request."""
    return Vector(float(wire[0]), float(wire[1]), float(wire[2]))


def read_pose(wire: Sequence[Sequence[float]]) -> Pose:
    """Return a `Transform` of a request."""
    rotation = wire[1]
    return Pose(read_vector(wire[0]), Rotation(float(rotation[0]), float(rotation[1]), float(rotation[2])))


def read_attributes(wire: Sequence[Sequence[Any]], version: ClientVersion) -> dict[str, tuple[AttributeType, str]]:
    """Return the attribute values of an `ActorDescription`."""
    offset = version.attribute_type_offset
    return {str(item[0]): (AttributeType(int(item[1]) - offset), str(item[2])) for item in wire}
