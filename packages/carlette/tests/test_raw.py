"""Requests that no well-behaved client sends get an answer, never a hang."""

from __future__ import annotations

import select
import socket
import struct
import time
from collections.abc import Iterator
from typing import Any

import pytest

from carlette.watchdog.pacing import HANDSHAKE_LIMIT_S
from raw_client import IMU, NOWHERE, SYNCHRONOUS, Raw, exactly, open_stream, places
from serving import running_server

pytestmark = pytest.mark.integration


@pytest.fixture(scope="module")
def port() -> Iterator[int]:
    with running_server() as port:
        yield port


@pytest.fixture
def raw(port: int) -> Iterator[Raw]:
    client = Raw(port)
    yield client
    client.socket.close()


def test_an_unknown_method_is_named_in_the_error(raw: Raw) -> None:
    error, _ = raw.call("make_coffee")
    assert "make_coffee" in error


@pytest.mark.parametrize(
    "call",
    [
        ("destroy_actor",),
        ("destroy_actor", "seven"),
        ("spawn_actor", [], []),
        ("spawn_actor", [1, "vehicle.tesla.model3", []], [[0, 0], [0]]),
        ("spawn_actor", [1, "vehicle.tesla.model3", 5], [[0, 0, 0], [0, 0, 0]]),
        ("get_actors_by_id", 5),
        ("set_episode_settings", []),
        ("set_episode_settings", [True, False, [True, 1e-300], True, 0.1, 1, 0, True, 1, 1, True]),
        ("set_episode_settings", [True, False, [True, -1.0], True, 0.1, 1, 0, True, 1, 1, True]),
        ("apply_batch", 5),
        ("project_point", [0, 0, 0], [0, 0, 0], 5.0),
        ("set_traffic_light_state", 1, 99),
        ("apply_control_to_vehicle", 1, [0]),
        ("set_weather_parameters", [float("nan")] * 14),
    ],
)
def test_bad_arguments_get_an_error_response(raw: Raw, call: tuple[Any, ...]) -> None:
    error, result = raw.call(*call)
    assert error is None
    assert result[0][0] in (0, True)
    assert raw.call("version") == (None, [[1, "0.9.16"]])


def test_a_bad_command_does_not_spoil_its_batch(raw: Raw) -> None:
    _, results = raw.call("apply_batch", [[[99, [1]]], [[1, ["x"]]], [[20, ["stat fps"]]]], False)
    assert [result[0][0] for result in results] == [0, 0, 1]


def test_a_stream_that_never_comes_delays_one_tick_only(raw: Raw) -> None:
    raw.call("set_episode_settings", SYNCHRONOUS)
    raw.call("get_sensor_token", 4711)
    start = time.monotonic()
    frames = [raw.call("tick_cue")[1][0][1] for _ in range(20)]
    assert frames == list(range(frames[0], frames[0] + 20))
    assert time.monotonic() - start < 10.0 * HANDSHAKE_LIMIT_S  # of 20 ticks; a busy machine is slow by itself


def test_late_subscriber_misses_no_measurement(port: int, raw: Raw) -> None:
    """A subscriber that connects after the server has stopped waiting for it still gets all measurements."""
    raw.call("set_episode_settings", SYNCHRONOUS)
    _, ((_, sensor),) = raw.call("spawn_actor", IMU, NOWHERE)
    stream_id = int.from_bytes(sensor[-1][:4], "little")
    raw.call("get_sensor_token", stream_id)
    ticked = [raw.call("tick_cue")[1][0][1] for _ in range(3)]
    assert raw.call("get_episode_settings")[0] is None  # the ticks before are done
    stream = open_stream(port, stream_id)
    found = []
    for _ in ticked:
        (size,) = struct.unpack("<I", exactly(stream, 4))
        found.append(struct.unpack_from("<Q", exactly(stream, size), 8)[0])
    assert found == ticked
    raw.call("destroy_actor", sensor[0])
    stream.close()


def _first_frame(raw: Raw, stream: socket.socket) -> int:
    """Ticks until a subscription is heard: it comes by another connection than the calls."""
    while True:
        frame: int = raw.call("tick_cue")[1][0][1]
        if select.select([stream], [], [], 0.2)[0]:
            return frame


@pytest.mark.parametrize("managers", [0, 1])
def test_what_is_asked_after_a_tick_comes_after_it(port: int, raw: Raw, managers: int) -> None:
    spectator = raw.call("get_spectator")[1][0][1][0]
    raw.call("set_episode_settings", SYNCHRONOUS)
    raw.call("set_actor_location", spectator, [1.0, 0.0, 0.0])
    if managers:
        raw.call("add_traffic_manager_running", ["127.0.0.1", 9])
    with open_stream(port, 1) as stream:
        frames = [_first_frame(raw, stream)]
        answers = raw.call_together(("tick_cue",), ("set_actor_location", spectator, [2.0, 0.0, 0.0]), ("tick_cue",))
        frames += [answers[0][1][0][1], answers[2][1][0][1]]
        assert frames == list(range(frames[0], frames[0] + 3))
        seen = dict(places(stream, spectator, frames[-1]))
    assert [seen[frame] for frame in frames[1:]] == [1.0, 2.0]


def test_absurd_numbers_do_not_end_the_server(raw: Raw) -> None:
    spectator = raw.call("get_spectator")[1][0][1][0]
    for number in (1e30, -1e300, float("inf"), float("nan")):
        raw.call("set_actor_location", spectator, [number, 0.0, 0.0])
        raw.call("project_point", [number, 0.0, 0.0], [0.0, 0.0, -1.0], number)
        raw.call("spawn_actor", [1, "vehicle.tesla.model3", []], [[number, 0.0, 0.0], [0.0, number, 0.0]])
    raw.call("tick_cue")
    assert raw.call("version") == (None, [[1, "0.9.16"]])


def test_big_messages_arrive_whole(raw: Raw) -> None:
    error, result = raw.call("copy_opendrive_to_file", "<x>" + "y" * 12_000_000, [])
    assert error is None
    assert result[0][0] is True


def test_ackermann_control_too_short_is_rejected_without_harm(raw: Raw) -> None:
    """An Ackermann control with too few values is rejected, and the server continues."""
    raw.call("set_episode_settings", SYNCHRONOUS)
    car = raw.call("spawn_actor", [1, "vehicle.tesla.model3", []], [[0.0, 0.0, 50.0], [0.0, 0.0, 0.0]])[1][0][1][0]
    _, result = raw.call("apply_ackermann_control_to_vehicle", car, [0.0, 0.0])
    assert result[0][0] is True and "jerk" in result[0][1][0]
    frame = raw.call("tick_cue")[1][0][1]
    assert raw.call("tick_cue")[1][0][1] == frame + 1


def test_settings_that_others_could_not_read_are_refused(raw: Raw) -> None:
    raw.call("set_episode_settings", SYNCHRONOUS)
    before = raw.call("get_episode_settings")
    for at, nonsense in ((4, "seven"), (5, 2**40), (6, float("nan")), (8, [])):
        wire = [*SYNCHRONOUS[:at], nonsense, *SYNCHRONOUS[at + 1 :]]
        assert raw.call("set_episode_settings", wire)[1][0][0] == 0
    assert raw.call("get_episode_settings") == before
