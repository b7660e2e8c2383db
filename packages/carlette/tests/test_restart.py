"""The server dies under a client that is driving, and is started again on the same port."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator

import pytest

from serving import READY

pytest.importorskip("carla")
pytestmark = pytest.mark.integration

CLIENT = """
import sys
import carla

def world_of(client):
    client.set_timeout(60.0)
    world = client.get_world()
    settings = world.get_settings()
    settings.synchronous_mode, settings.fixed_delta_seconds = True, 0.05
    world.apply_settings(settings)
    return world

port = int(sys.argv[1])
client = carla.Client("127.0.0.1", port)
world = world_of(client)
imu = world.spawn_actor(world.get_blueprint_library().find("sensor.other.imu"), carla.Transform())
imu.listen(lambda measured: None)
print("ticks", world.tick(), flush=True)
input()
client.set_timeout(1.0)
try:
    world.tick()
except RuntimeError as error:
    print("error", str(error)[:8], flush=True)
input()
again = carla.Client("127.0.0.1", port)
print("ticks", world_of(again).tick(), flush=True)
"""

Start = Callable[[int], "tuple[subprocess.Popen[str], int]"]


@pytest.fixture
def start() -> Iterator[Start]:
    """Starts a server on a port, or on one that it chooses (0): it needs the next one too. What is left is ended."""
    servers: list[subprocess.Popen[str]] = []

    def begin(port: int) -> tuple[subprocess.Popen[str], int]:
        command = [sys.executable, "-m", "carlette", "--port", str(port), "--exit-on-stdin-eof"]
        server = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        servers.append(server)
        assert server.stdout is not None
        ready = READY.match(server.stdout.readline())
        assert ready
        return server, int(ready[2])

    yield begin
    for server in servers:
        server.kill()
        server.communicate()


def test_client_gets_error_and_new_one_drives_after_restart(start: Start) -> None:
    """After the server dies, the client gets an error, and a new client of the same process drives on."""
    server, port = start(0)
    with subprocess.Popen(
        [sys.executable, "-c", CLIENT, str(port)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as client:
        assert client.stdin is not None and client.stdout is not None
        assert client.stdout.readline().startswith("ticks ")
        server.kill()
        server.wait()
        print(file=client.stdin, flush=True)
        assert client.stdout.readline() == "error time-out\n"
        start(port)
        print(file=client.stdin, flush=True)
        assert client.stdout.readline().startswith("ticks ")
        client.kill()
