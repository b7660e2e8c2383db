"""Whatever one peer does to its connections, the others are served."""

from __future__ import annotations

import signal
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Iterator

import msgpack
import pytest

from raw_client import SYNCHRONOUS, Raw, open_stream
from serving import free_port, running_server

pytest.importorskip("carla")

pytestmark = pytest.mark.integration

WORLD_STREAM = 1
USUAL_TICKS = 20
RESET_ON_CLOSE = struct.pack("ii", 1, 0)

DRIVES_FOR_EVER = """
import carla, sys
client = carla.Client("127.0.0.1", int(sys.argv[1]))
client.set_timeout(60.0)
world = client.get_world()
settings = world.get_settings()
settings.synchronous_mode, settings.fixed_delta_seconds = True, 0.05
world.apply_settings(settings)
manager = client.get_trafficmanager(int(sys.argv[2]))
print("ticking", flush=True)
while True:
    world.tick()
"""


@pytest.fixture(scope="module")
def port() -> Iterator[int]:
    with running_server() as port:
        yield port


@pytest.fixture
def raw(port: int) -> Iterator[Raw]:
    client = Raw(port)
    client.call("set_episode_settings", SYNCHRONOUS)
    began = time.monotonic()
    for _ in range(USUAL_TICKS):
        client.call("tick_cue")
    client.usual_s = time.monotonic() - began
    yield client
    client.socket.close()


def serves(client: Raw, ticks: int = 20) -> bool:
    """True when ticks come without a gap, and none waits for another peer, which takes seconds.

    A busy machine is slow with every tick: with those before, too, when there were no other peers.
    """
    start = time.monotonic()
    frames = [client.call("tick_cue")[1][0][1] for _ in range(ticks)]
    longest_s = 1.0 + 0.05 * ticks + 10.0 * client.usual_s * ticks / USUAL_TICKS
    return frames == list(range(frames[0], frames[0] + ticks)) and time.monotonic() - start < longest_s


def test_peers_that_are_gone_before_they_are_accepted(port: int, raw: Raw) -> None:
    for number in range(100):
        sock = socket.create_connection(("127.0.0.1", port + number % 2), timeout=60)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET_ON_CLOSE)
        sock.close()
    assert serves(raw)


def test_peers_that_say_nothing_or_only_half(port: int, raw: Raw) -> None:
    request = msgpack.packb([0, 1, "version", [[False]]])
    halves = [(port, b""), (port, request[:5]), (port + 1, b""), (port + 1, b"\x01\x00")]
    socks = []
    for where, data in halves:
        sock = socket.create_connection(("127.0.0.1", where), timeout=60)
        sock.sendall(data)
        socks.append(sock)
    assert serves(raw)
    socks[1].sendall(request[5:])
    assert msgpack.unpackb(socks[1].recv(1000))[3] == [[1, "0.9.16"]]
    for sock in socks:
        sock.close()
    assert serves(raw)


NOISE = [b"GET / HTTP/1.1\r\n\r\n", b"\x91" * 100_000, b"\xc1" * 100, b"\xff" * 5000]
LIST_AS_KEY = b"\x81\x90\x01"


@pytest.mark.parametrize("noise", [*NOISE, LIST_AS_KEY])
def test_peers_that_speak_something_else(port: int, raw: Raw, noise: bytes) -> None:
    for where in (port, port + 1):
        with socket.create_connection(("127.0.0.1", where), timeout=60) as sock:
            sock.sendall(noise)
    assert serves(raw)


def test_peers_that_ask_and_never_read(port: int, raw: Raw) -> None:
    deaf = socket.create_connection(("127.0.0.1", port), timeout=60)
    for number in range(100):
        deaf.sendall(msgpack.packb([0, number, "get_map_data", [[False]]]))
    stream = open_stream(port, WORLD_STREAM)
    assert serves(raw, ticks=300)
    deaf.close()
    stream.close()
    assert serves(raw)


def test_killed_client_takes_its_traffic_manager_along(port: int, raw: Raw) -> None:
    """The traffic manager of a client that is killed between ticks counts as gone."""
    manager = free_port()
    with subprocess.Popen(
        [sys.executable, "-c", DRIVES_FOR_EVER, str(port), str(manager)], stdout=subprocess.PIPE, text=True
    ) as client:
        assert client.stdout is not None
        assert client.stdout.readline() == "ticking\n"
        assert raw.call("is_traffic_manager_running", manager)[1] == [[1, True]]
        time.sleep(0.2)
        client.send_signal(signal.SIGKILL)
    assert serves(raw)
    assert raw.call("is_traffic_manager_running", manager)[1] == [[1, False]]


def test_a_client_that_stands_still_holds_up_nobody(port: int, raw: Raw) -> None:
    command = [sys.executable, "-c", DRIVES_FOR_EVER, str(port), str(free_port())]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as client:
        assert client.stdout is not None
        try:
            client.stdout.readline()
            client.send_signal(signal.SIGSTOP)
            # Its traffic manager does not answer either: snapshots are held back for it, but not for ever.
            # One of its own ticks may still be on its way when it is stopped.
            frames = [raw.call("tick_cue")[1][0][1] for _ in range(4)]
            assert frames[-1] == frames[-2] + 1
        finally:
            client.kill()
    assert serves(raw)


def test_a_sensors_stream_has_another_number_in_the_next_episode(raw: Raw) -> None:
    tokens = []
    for _ in range(2):
        raw.call("load_new_episode", "", False, 0xFFFF)
        spectator = raw.call("get_spectator")[1][0][1][0]
        sensor = [1, "sensor.other.collision", []]
        actor = raw.call("spawn_actor_with_parent", sensor, [[0, 0, 0], [0, 0, 0]], spectator, 0)[1][0][1]
        tokens.append(actor[5])
    assert len(tokens[0]) == 24
    assert tokens[0] != tokens[1]
