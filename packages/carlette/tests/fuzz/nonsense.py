"""What a broken or hostile client could send: calls that are nearly right, calls that are nonsense, and noise."""

from __future__ import annotations

import math
import random
import socket
import struct
from collections.abc import Callable, Sequence
from typing import Any

import msgpack
from hypothesis import strategies as st

from carlette.rpc.handlers import ALL
from raw_client import SYNCHRONOUS, Raw, exactly, open_stream

RECORD_BYTES = 119
RECORDS_AT = 84
MOTION = struct.Struct("<15f")
NUMBERS = (0, 1, -1, 7, 255, 2**31, 2**32, 2**63 - 1, -(2**63), 0.5, -0.0, 1e-300, 1e30, -1e308)
NOT_NUMBERS = (float("nan"), float("inf"), float("-inf"))
OTHERS = (None, True, False, "", "seven", "vehicle.tesla.model3", "x" * 5000, b"", b"\xff\xfe", [], [[]], {}, {"a": 1})
TYPES = ("vehicle.tesla.model3", "walker.pedestrian.0001", "static.prop.constructioncone", "sensor.other.collision")
TEXTS = ("", "demo_town", "Atlantis", "nowhere/at/all", "\0", "<OpenDRIVE/>", "<" * 1000)
Make = Callable[[random.Random, Sequence[int]], Any]


class Healthy:
    """A client that does everything right, and must be served whatever the others do."""

    def __init__(self, port: int) -> None:
        self._port = port
        self._raw = Raw(port)
        self._stream = open_stream(port, 1)

    def load_new_world(self) -> None:
        """An empty world; it subscribes again, as the real client does: until then the server sends no snapshot."""
        error, _ = self._raw.call("load_new_episode", "", False, 0)
        assert error is None
        self._stream.close()
        self._stream = open_stream(self._port, 1)

    def check(self) -> None:
        """A tick is answered, its snapshot comes, and all numbers in it are finite; fails otherwise."""
        error, result = self._raw.call("set_episode_settings", SYNCHRONOUS)
        assert error is None and result[0][0] == 1
        frame, seen = self._raw.call("tick_cue")[1][0][1], 0
        while seen < frame:
            message = exactly(self._stream, struct.unpack("<I", exactly(self._stream, 4))[0])
            seen = struct.unpack_from("<Q", message, 8)[0]
        assert seen == frame
        for at in range(RECORDS_AT, len(message), RECORD_BYTES):
            motion = MOTION.unpack_from(message, at + 5)
            assert all(map(math.isfinite, motion)), f"actor {struct.unpack_from('<I', message, at)[0]}: {motion}"

    def close(self) -> None:
        self._raw.socket.close()
        self._stream.close()


def method_names() -> list[str]:
    """All that a client can call."""
    return sorted({*ALL.calls, "tick_cue"})


def actor_ids(raw: Raw) -> list[int]:
    """The spectator, a light, and one actor of each kind, spawned for the purpose."""
    raw.call("set_episode_settings", SYNCHRONOUS)
    ids = [1, 2]
    for place, kind in enumerate(TYPES):
        answer = raw.call("spawn_actor", [1, kind, []], [[40.0 + 9.0 * place, 300.0, 1.0], [0.0, 0.0, 0.0]])[1][0]
        ids += [answer[1][0]] if answer[0] == 1 else []
    return ids


def _scalar(chance: random.Random, actors: Sequence[int]) -> Any:
    return chance.choice((*NUMBERS, *NOT_NUMBERS, *OTHERS, *actors))


def _number(chance: random.Random, actors: Sequence[int]) -> Any:
    del actors
    return chance.choice(NUMBERS + NOT_NUMBERS) if chance.random() < 0.4 else chance.uniform(-100.0, 100.0)


def _actor(chance: random.Random, actors: Sequence[int]) -> Any:
    return chance.choice(actors)


def _list_of(make: Make, count: int) -> Make:
    return lambda chance, actors: [make(chance, actors) for _ in range(count)]


_vector = _list_of(_number, 3)
_pose = _list_of(_vector, 2)


def _flag(chance: random.Random, actors: Sequence[int]) -> bool:
    del actors
    return chance.random() < 0.5


def _control(chance: random.Random, actors: Sequence[int]) -> Any:
    pedals = [_number(chance, actors) for _ in range(3)]
    return [*pedals, *(_flag(chance, actors) for _ in range(3)), chance.choice(NUMBERS)]


def _text(chance: random.Random, actors: Sequence[int]) -> str:
    del actors
    return chance.choice(TEXTS)


def _description(chance: random.Random, actors: Sequence[int]) -> Any:
    names = ("color", "role_name", "sticky_control", "scale", "sensor_tick", "is_invincible", "nonsense")
    values = ("", "nan", "-1", "1e999", "true", "300,-1,x", "x" * 2000)
    attributes = [
        [chance.choice(names), chance.randrange(8), chance.choice(values)] for _ in range(chance.randrange(4))
    ]
    return [chance.choice(NUMBERS), chance.choice((*TYPES, "vehicle.*", "")), attributes]


def _settings(chance: random.Random, actors: Sequence[int]) -> Any:
    numbers = [_number(chance, actors) for _ in range(8)]
    return [_flag(chance, actors), False, [chance.random() < 0.8, _number(chance, actors)], *numbers]


ABOUT_ACTORS: dict[str, tuple[Make, ...]] = {
    "transform": (_pose,),
    "location": (_vector,),
    "velocity": (_vector,),
    "impulse": (_vector,),
    "force": (_vector,),
    "torque": (_vector,),
    "control_to_vehicle": (_control,),
    "light_state": (_list_of(_number, 1),),
    "traffic_light": (_number,),
    "door": (_number,),
    "wheel": (_number, _number),
    "blend": (_number,),
    "simulate": (_flag,),
    "collisions": (_flag,),
    "gravity": (_flag,),
}
"""What follows the actor's id, by a part of the method's name."""
OTHER_CALLS: dict[str, tuple[Make, ...]] = {
    "set_episode_settings": (_settings,),
    "load_new_episode": (_text, _flag, _number),
    "copy_opendrive_to_file": (_text, _list_of(_number, 7)),
    "spawn_actor": (_description, _pose),
    "spawn_actor_with_parent": (_description, _pose, _actor, _number, _text),
    "set_weather_parameters": (_list_of(_number, 14),),
    "project_point": (_vector, _vector, _number),
    "cast_ray": (_vector, _vector),
    "get_actors_by_id": (_list_of(_actor, 3),),
    "get_sensor_token": (_number,),
    "get_environment_objects": (_number,),
    "apply_control_to_walker": (
        _actor,
        lambda chance, actors: [_vector(chance, actors), _number(chance, actors), True],
    ),
    "apply_ackermann_control_to_vehicle": (_actor, _list_of(_number, 5)),
    "apply_ackermann_controller_settings": (_actor, _list_of(_number, 6)),
    "freeze_all_traffic_lights": (_flag,),
    "tick_cue": (),
}


def likely_arguments(chance: random.Random, method: str, actors: Sequence[int]) -> list[Any]:
    """Arguments of the right shape, with wild numbers in them; sometimes one of them is something else."""
    found = OTHER_CALLS.get(method)
    if found is None:
        found = (_actor, *next((makes for part, makes in ABOUT_ACTORS.items() if part in method), ()))
    arguments = [make(chance, actors) for make in found]
    if arguments and chance.random() < 0.25:
        arguments[chance.randrange(len(arguments))] = shapes(chance, actors)
    return arguments


def shapes(chance: random.Random, actors: Sequence[int], depth: int = 3) -> Any:
    """Anything that msgpack can carry."""
    if depth == 0 or chance.random() < 0.5:
        return _scalar(chance, actors)
    return [shapes(chance, actors, depth - 1) for _ in range(chance.randrange(5))]


def likely_commands(chance: random.Random, actors: Sequence[int]) -> list[Any]:
    """A batch: each command's index with a payload that may fit."""
    spawn = [_description(chance, actors), _pose(chance, actors), [False], []]
    payloads: list[Make] = [_pose, _vector, _control, _number, _flag, shapes]
    commands = []
    for _ in range(chance.randrange(12)):
        index = chance.randrange(24)
        after = chance.choice(payloads)(chance, actors)
        commands.append([[index, spawn if index == 0 else [chance.choice(actors), after]]])
    return commands


def fixed_calls() -> list[tuple[Any, ...]]:
    """Calls with each number that is none where a number belongs."""
    calls: list[tuple[Any, ...]] = []
    for bad in (*NOT_NUMBERS, 1e30, -1e308):
        calls += [
            ("apply_control_to_vehicle", [bad, bad, bad, False, False, False, 0]),
            ("apply_control_to_walker", [[bad, bad, bad], bad, False]),
            ("apply_ackermann_control_to_vehicle", [bad] * 5),
            ("set_actor_transform", [[bad, 0.0, 0.0], [0.0, 0.0, 0.0]]),
            ("set_actor_transform", [[0.0, 0.0, 0.0], [0.0, bad, 0.0]]),
            ("set_actor_target_velocity", [bad, 0.0, 0.0]),
            ("set_actor_target_angular_velocity", [0.0, 0.0, bad]),
            ("enable_actor_constant_velocity", [bad, 0.0, 0.0]),
            ("add_actor_impulse", [bad, 0.0, 0.0]),
            ("add_actor_angular_impulse", [0.0, 0.0, bad]),
            ("set_traffic_light_green_time", bad),
        ]
    return calls


def frames_of_noise() -> st.SearchStrategy[bytes]:
    """Bytes for a port: random, a request that is cut or changed, or one that claims to be huge."""
    requests = st.tuples(st.sampled_from(method_names()), st.integers(0, 2**32)).map(packed_request)
    cut = st.tuples(requests, st.integers(0, 60)).map(lambda both: both[0][: both[1]])
    changed = st.tuples(requests, st.integers(0, 59), st.integers(0, 255)).map(_changed)
    huge = st.sampled_from(
        [b"\xdd\xff\xff\xff\xff", b"\xdb\xff\xff\xff\xff", b"\xc6\xff\xff\xff\xff", b"\xdf\x7f\xff\xff\xff"]
    )
    return st.one_of(st.binary(max_size=300), requests, cut, changed, huge, st.tuples(requests, huge).map(b"".join))


def packed_request(drawn: tuple[str, int]) -> bytes:
    """A call of a method with the likely arguments of a seed, as bytes."""
    method, seed = drawn
    chance = random.Random(seed)
    packed: bytes = msgpack.packb([0, seed, method, [[False], *likely_arguments(chance, method, (1, 2))]])
    return packed


def _changed(drawn: tuple[bytes, int, int]) -> bytes:
    data, at, byte = drawn
    return data[:at] + bytes([byte]) + data[at + 1 :]


def resets(sock: socket.socket) -> None:
    """Lets a socket end with a reset instead of a farewell."""
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
