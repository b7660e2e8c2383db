"""Calls that are well-formed and far too large, or carry numbers that are none, are refused and cost little."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from carlette.client_versions import DEFAULT_VERSION, VERSIONS
from carlette.errors import RequestError
from carlette.recorder import LogRecorder, Replay, read_tape
from carlette.recorder.log_file import MAGIC, encode_entry
from carlette.rpc.handlers.actors import MOST_TEXT
from carlette.rpc.handlers.batch import MOST_COMMANDS
from carlette.simulator import Simulator
from carlette.world.spawn import MOST_ACTORS, spawn
from raw_client import IMU, NOWHERE, SYNCHRONOUS, Raw
from serving import running_server
from straight import add, straight_world

CONE = [1, "static.prop.constructioncone", []]
NAN, INF = float("nan"), float("inf")


@pytest.fixture(scope="module")
def port(tmp_path_factory) -> Iterator[int]:
    with running_server("--recordings", str(tmp_path_factory.mktemp("logs"))) as port:
        yield port


@pytest.fixture
def raw(port: int) -> Iterator[Raw]:
    client = Raw(port)
    client.socket.settimeout(30.0)
    client.call("set_episode_settings", SYNCHRONOUS)
    client.call("load_new_episode", "", False, 0)
    yield client
    client.socket.close()


def told(answer) -> str:
    """The text of a refusal."""
    error, ((failed, *text),) = answer
    assert error is None and failed in (0, True), answer
    return str(text[0][0])


def actors_of(raw: Raw) -> int:
    """One more than have been spawned."""
    return int(raw.call("spawn_actor", IMU, NOWHERE)[1][0][1][0])


def spawn_command(after: list[Any]) -> list[Any]:
    return [[0, [CONE, NOWHERE, [False], after]]]


def test_batch_with_too_many_commands_is_rejected_whole(raw: Raw) -> None:
    """A batch with too many commands is rejected whole, with the reason for each command."""
    first = actors_of(raw)
    error, answers = raw.call("apply_batch", [spawn_command([])] * (MOST_COMMANDS + 1), False)
    assert error is None and len(answers) == MOST_COMMANDS + 1
    assert all(str(MOST_COMMANDS) in str(item) for item in (answers[0], answers[-1]))
    assert actors_of(raw) == first + 1, "nothing was spawned"


def test_commands_within_commands_are_counted_too(raw: Raw) -> None:
    first = actors_of(raw)
    nested = spawn_command([spawn_command([])] * (MOST_COMMANDS // 2))
    _, answers = raw.call("apply_batch", [nested, nested], False)
    assert len(answers) == 2 and str(MOST_COMMANDS) in str(answers[0])
    assert actors_of(raw) == first + 1


@pytest.mark.integration
def test_batch_with_maximum_commands_is_executed(raw: Raw) -> None:
    """A batch with the maximum number of commands is executed."""
    destroy = [[1, [999_999]]]
    error, answers = raw.call("apply_batch", [destroy] * MOST_COMMANDS, False)
    assert error is None and len(answers) == MOST_COMMANDS


@pytest.mark.integration
def test_world_at_actor_limit_rejects_spawn() -> None:
    """A world with the maximum number of actors rejects a spawn, and the error says to destroy some."""
    world = straight_world()
    for number in range(MOST_ACTORS - len(world.actors)):
        world.enter("other", world.spectator.kind, world.pose(world.spectator), world.spectator.box)
        del number
    with pytest.raises(RequestError, match=f"{MOST_ACTORS:,}.*destroy"):
        spawn(world, "static.prop.constructioncone", {}, world.pose(world.spectator))


def test_actor_requested_a_million_times_is_returned_once(raw: Raw) -> None:
    """An actor that is requested a million times is returned once."""
    first, second = actors_of(raw), actors_of(raw)
    _, ((_, found),) = raw.call("get_actors_by_id", [second, first] * 500_000)
    assert [item[0] for item in found] == [second, first]


@pytest.mark.parametrize("bad", [NAN, INF, -INF, 1e30])
@pytest.mark.parametrize("at", [(part, axis) for part in (0, 1) for axis in range(3)])
def test_nothing_is_spawned_where_there_is_no_place(raw: Raw, bad: float, at: tuple[int, int]) -> None:
    part, axis = at
    nowhere = [list(item) for item in NOWHERE]
    nowhere[part][axis] = bad
    for kind in ("vehicle.tesla.model3", "walker.pedestrian.0001", "sensor.other.imu", "static.prop.mesh"):
        assert "not finite" in told(raw.call("spawn_actor", [1, kind, []], nowhere))
        assert "not finite" in told(raw.call("spawn_actor_with_parent", [1, kind, []], nowhere, 1, 0))
    _, answers = raw.call("apply_batch", [[[0, [CONE, nowhere, [False], []]]]], False)
    assert "not finite" in str(answers)


@pytest.mark.parametrize(
    "attributes",
    [[["role_name", 3, "x" * MOST_TEXT]], [[f"a{i}", 3, "y"] for i in range(MOST_TEXT)]],
    ids=["a long one", "many"],
)
def test_an_actors_attributes_are_no_place_to_keep_data(raw: Raw, attributes: list[Any]) -> None:
    assert f"{MOST_TEXT:,}" in told(raw.call("spawn_actor", [1, "sensor.other.imu", attributes], NOWHERE))


def test_walker_unknown_bone_is_rejected(raw: Raw) -> None:
    """A walker accepts only bones that it has."""
    walker = raw.call("spawn_actor", [1, "walker.pedestrian.0001", []], [[40.0, 300.0, 1.0], [0.0, 0.0, 0.0]])
    number = walker[1][0][1][0]
    assert "crl_tail" in told(raw.call("set_bones_transform", number, [[["crl_tail", NOWHERE]]]))
    assert raw.call("set_bones_transform", number, [[["crl_Head__C", NOWHERE]]]) == (None, [[False]])


@pytest.mark.parametrize("port_number", [0, -1, 65_536, 2**60])
def test_a_traffic_manager_has_a_port_that_there_is(raw: Raw, port_number: int) -> None:
    assert "1 to 65535" in told(raw.call("add_traffic_manager_running", ["127.0.0.1", port_number]))


def test_a_traffic_managers_address_is_no_place_to_keep_data(raw: Raw) -> None:
    assert "255" in told(raw.call("add_traffic_manager_running", ["x" * 256, 8000]))


def test_stream_hub_awaited_unknown_streams_are_bounded() -> None:
    """The number of unknown streams for which the server waits is bounded."""
    from carlette.streaming import MOST_AWAITED, StreamHub

    hub = StreamHub()
    for number in range(2 * MOST_AWAITED):
        hub.expect(number)
    assert len(hub.awaited) == MOST_AWAITED


@pytest.mark.parametrize(
    "name", ["x" * 300, "a/" * 3000 + "b", "x" * 100_000, "\0"], ids=["long", "deep", "huge", "null"]
)
@pytest.mark.parametrize("call", ["start_recorder", "show_recorder_file_info", "replay_file"])
def test_recorder_impossible_file_name_is_one_line_error(raw: Raw, call: str, name: str) -> None:
    """A name that no file can have is an error of one line, with an example of a valid name."""
    more = [0.0, 0.0, 0, False] if call == "replay_file" else [False]
    error, ((index, answer),) = raw.call(call, name, *more)
    assert error is None and index == 1, "the recorder answers with texts, as CARLA's does"
    assert "failed in the server" not in answer and "give one such as run.log" in answer
    assert len(answer) < 600


FRAME: dict[str, Any] = {
    "ids": np.array([1], np.uint32),
    "motion": np.zeros((1, 9), np.float32),
    "lights": np.zeros(0, np.uint32),
    "colors": np.zeros(0, np.uint8),
}


def tape(path, change: dict[str, Any], spawned: int = 1):
    """A log of two frames of which the second is changed."""
    parts = [
        MAGIC,
        encode_entry("start", "straight", ""),
        encode_entry("spawn", spawned, "vehicle.tesla.model3", {}, 0),
    ]
    for number, frame in enumerate((FRAME, FRAME | change)):
        values = [frame[item].tobytes() for item in ("ids", "motion", "lights", "colors")]
        parts.append(encode_entry("frame", number, frame.get("time_s", 0.05 * number), *values))
    path.write_bytes(b"".join(parts))
    return path


@pytest.mark.parametrize(
    ("change", "spawned"),
    [
        ({"motion": np.zeros((3, 9), np.float32)}, 1),
        ({"motion": np.full((1, 9), NAN, np.float32)}, 1),
        ({"motion": np.full((1, 9), 1e20, np.float32)}, 1),
        ({"ids": np.array([77], np.uint32)}, 1),
        ({"colors": np.array([99], np.uint8), "lights": np.array([3], np.uint32)}, 1),
        ({"lights": np.array([3, 4], np.uint32)}, 1),
        ({"time_s": NAN}, 1),
        ({"ids": np.array([2**32 - 1], np.uint32)}, 2**32 - 1),
    ],
    ids=["more motion", "nan", "far", "unknown", "no colour", "no colours", "no time", "a huge id"],
)
def test_recorder_damaged_log_never_crashes_server(tmp_path, change, spawned) -> None:
    """A damaged log is rejected or ends its replay, and the server continues."""
    path = tape(tmp_path / "x.log", change, spawned)
    simulator = Simulator(straight_world().roads, VERSIONS[DEFAULT_VERSION], [], 0)
    simulator.world.settings = simulator.world.settings.__class__(True, False, 0.05)
    try:
        simulator.replay = Replay(read_tape(path), simulator.world)
    except RequestError as error:
        assert str(path) in str(error)
    for _ in range(5):
        simulator.tick()
    assert np.isfinite(simulator.world.bodies.position).all()


@pytest.mark.integration
def test_a_sound_log_is_played_as_before(tmp_path) -> None:
    world = straight_world()
    car = add(world)
    recorder = LogRecorder(tmp_path / "good.log", world)
    for _ in range(3):
        world.bodies.position[car.row, 0] += 1.0
        world.tick()
        recorder.note(world)
    recorder.stop()
    assert len(read_tape(tmp_path / "good.log").frames) == 4
