"""Many actors, many peers, clients that quarrel, are killed or outlive their server."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from nonsense import Healthy

from raw_client import SYNCHRONOUS, Raw
from serving import running_server

pytestmark = pytest.mark.integration
pytest.importorskip("carla")

ACTORS = 3000
BATCH = 250
SPACING_M = 25.0
FILES, PEERS = 100, 300
FEW_FILES = f"import resource as r; r.setrlimit(r.RLIMIT_NOFILE, ({FILES},) * 2); from carlette import cli; cli.main()"
QUARREL_ROUNDS = 60
VERSION = "0.9.16"

OUTLIVES_ITS_SERVER = Path(__file__).with_name("outlive.py")


@pytest.fixture
def port() -> Iterator[int]:
    with running_server("--map", "demo_town") as port:
        yield port


@pytest.mark.release
def test_three_thousand_actors_are_spawned_moved_and_destroyed(port: int) -> None:
    healthy, raw = Healthy(port), Raw(port)
    raw.call("set_episode_settings", SYNCHRONOUS)
    ids: list[int] = []
    for first in range(0, ACTORS, BATCH):
        commands = [spawn_command(number) for number in range(first, first + BATCH)]
        answers = raw.call("apply_batch", commands, False)[1]
        ids += [answer[0][1] for answer in answers if answer[0][0] == 1]
    assert len(set(ids)) == ACTORS
    healthy.check()
    gone = raw.call("apply_batch", [[[1, [object_id]]] for object_id in ids], False)[1]
    assert all(answer[0][0] == 1 for answer in gone)
    healthy.check()
    healthy.close()
    raw.socket.close()


def spawn_command(number: int) -> list[object]:
    kind = "vehicle.tesla.model3" if number % 3 == 0 else "static.prop.constructioncone"
    place = [SPACING_M * (number % 60), SPACING_M * (number // 60) + 500.0, 1.0]
    return [[0, [[1, kind, []], [place, [0.0, 0.0, 0.0]], [False], []]]]


@pytest.mark.slow
def test_more_peers_than_the_server_may_have_files() -> None:
    with running_server("--map", "demo_town", program=("-c", FEW_FILES)) as port:
        healthy = Healthy(port)
        peers = [socket.create_connection(("127.0.0.1", port + number % 2), timeout=60) for number in range(PEERS)]
        healthy.check()
        one_more = Raw(port)
        one_more.socket.settimeout(2.0)
        with pytest.raises((AssertionError, OSError)):
            one_more.call("version")
        for peer in peers:
            peer.close()
        healthy.check()
        assert Raw(port).call("version") == (None, [[1, VERSION]])
        healthy.close()


def test_two_clients_that_fight_over_the_settings_both_get_answers(port: int) -> None:
    one, other, healthy = Raw(port), Raw(port), Healthy(port)
    for number in range(QUARREL_ROUNDS):
        one.call("set_episode_settings", SYNCHRONOUS)
        other.call("set_episode_settings", [False, False, [number % 2 == 0, 0.1], *SYNCHRONOUS[3:]])
        frame = one.call("tick_cue")[1][0][1]
        assert other.call("tick_cue")[1][0][1] > frame
        if number % 20 == 0:
            one.call("load_new_episode", "", number % 40 == 0, 0)
    healthy.check()
    for client in (one, other, healthy):
        client.socket.close() if isinstance(client, Raw) else client.close()


def test_clients_that_are_killed_in_the_middle_of_a_tick(port: int) -> None:
    healthy = Healthy(port)
    program = (
        "import carla, sys\n"
        f"world = carla.Client('127.0.0.1', {port}).get_world()\n"
        "print(1, flush=True)\n"
        "while True: world.tick()"
    )
    for wait_s in (0.0, 0.003, 0.01, 0.05):
        with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE) as client:
            assert client.stdout is not None and client.stdout.readline()
            time.sleep(wait_s)
            client.send_signal(signal.SIGKILL)
        healthy.check()
    healthy.close()


@pytest.mark.slow
def test_client_survives_server_restart_and_continues() -> None:
    """A client survives the end of its server and continues with the next one on the same port."""
    with running_server("--map", "demo_town") as port:
        pass
    first = [sys.executable, "-m", "carlette", "--port", str(port), "--map", "demo_town"]
    with subprocess.Popen(first, stdout=subprocess.PIPE) as server:
        assert server.stdout is not None and server.stdout.readline()
        command = [sys.executable, str(OUTLIVES_ITS_SERVER), str(port)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stdin=subprocess.PIPE, text=True) as client:
            assert client.stdout is not None and client.stdin is not None
            assert client.stdout.readline() == "ticking\n"
            server.kill()
            server.wait()
            assert client.stdout.readline() == "error\n"
            with running_server("--map", "demo_town", "--port", str(port)):
                client.stdin.write("go on\n")
                client.stdin.flush()
                assert client.stdout.readline() == "ticking again\n"
                client.kill()
