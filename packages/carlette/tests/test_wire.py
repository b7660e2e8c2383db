"""The bytes and arrays on the wire are those that the client reads."""

from __future__ import annotations

import struct

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from carlette.blueprints import load_catalog
from carlette.client_versions import VERSIONS
from carlette.geometry import Pose, Rotation, Vector
from carlette.wire import encode
from carlette.wire.encode import stream_token
from carlette.wire.snapshot import RECORD, RECORD_BYTES, sensor_header, world_header

number = st.floats(-1e6, 1e6, width=32)


def test_actor_record_fields_have_client_offsets() -> None:
    """An actor record is packed, and its fields are at the offsets that the client reads."""
    assert RECORD.itemsize == RECORD_BYTES == 119
    records = np.zeros(2, RECORD)
    records["id"] = (7, 8)
    records["speed_limit"][1] = 50.0
    records["light_id"][1] = 99
    raw = records.tobytes()
    assert struct.unpack_from("<I", raw, 119) == (8,)
    assert struct.unpack_from("<f", raw, 119 + 84) == (50.0,)
    assert struct.unpack_from("<I", raw, 119 + 90) == (99,)


def test_a_light_record_carries_sign_times_and_state() -> None:
    record = np.zeros(1, RECORD)
    record["sign_id"], record["light_times"], record["color"] = b"362", (10, 3, 2), 2
    raw = record.tobytes()
    assert raw[65:97].rstrip(b"\0") == b"362"
    assert struct.unpack_from("<3f", raw, 97) == (10.0, 3.0, 2.0)
    assert raw[118] == 2


def test_headers_have_the_sizes_of_the_protocol() -> None:
    assert len(sensor_header(17, 5, 0.25)) == 48
    assert len(world_header(1, 0.05, 0)) == 36
    assert struct.unpack_from("<f", world_header(1, 0.05, 0), 16)[0] == np.float32(0.05)


def test_stream_token_has_stream_and_port_but_no_host() -> None:
    """A token contains the stream and the port, and leaves the host to the client."""
    token = stream_token(42, 2001)
    assert len(token) == 24
    assert struct.unpack_from("<IHBB", token) == (42, 2001, 1, 0)


@given(st.tuples(number, number, number), st.tuples(number, number, number))
def test_a_pose_survives_the_wire(place: tuple[float, ...], turn: tuple[float, ...]) -> None:
    pose = Pose(Vector(*place), Rotation(*turn))
    assert encode.read_pose(msgpack.unpackb(msgpack.packb(encode.pose(pose)))) == pose


def test_responses_tell_success_from_error_for_void_and_for_values() -> None:
    assert encode.value(5) == [[1, 5]]
    assert encode.failure("no") == [[0, ["no"]]]
    assert encode.done() == [[False]]
    assert encode.void_failure("no") == [[True, ["no"]]]


@pytest.mark.parametrize(("version", "boolean"), [("0.9.15", 0), ("0.9.16", 1)])
def test_attribute_types_shift_for_newer_client_and_read_back(version: str, boolean: int) -> None:
    """Attribute types are shifted for the newer client and read back correctly."""
    served = VERSIONS[version]
    car = load_catalog().definitions["vehicle.tesla.model3"]
    wire = encode.definition(1, car, served)
    kinds = {item[0]: item[1] for item in wire[3]}
    assert kinds["has_lights"] == boolean
    assert kinds["generation"] == boolean + 1
    sent_back = [[item[0], item[1], item[2]] for item in wire[3]]
    described = {name: kind for name, (kind, _) in encode.read_attributes(sent_back, served).items()}
    assert described == {attribute.id: attribute.type for attribute in car.attributes}


def test_a_collision_names_both_actors_and_the_impulse() -> None:
    body = encode.collision([1, "a"], [2, "b"], Vector(3.0, 4.0, 0.0))
    assert msgpack.unpackb(body) == [[1, "a"], [2, "b"], [3.0, 4.0, 0.0]]
