"""What the benchmarks of carlette share: its server as a process, and clients with traffic and sensors."""

from __future__ import annotations

import random
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from queue import Queue
from typing import IO, TYPE_CHECKING, Any

if TYPE_CHECKING:
    import carla

STEP_S = 0.05
"""Step of the simulation (s)."""
PROGRAM = ("-m", "carlette")
READY = re.compile(r"listening on \S+:(\d+) map=")
CAR = "vehicle.tesla.model3"


@contextmanager
def running_server(
    town: str = "demo_town",
    program: tuple[str, ...] = PROGRAM,
    log: IO[str] | None = None,
    folder: Path | None = None,
) -> Iterator[tuple[int, subprocess.Popen[str]]]:
    """Run a server on a free port; yield the port and the process.

    Args:
        town: A town or an .xodr file.
        program: Arguments of Python that run the server.
        log: File for its standard error; by default that of this process. An unread pipe would block the server.
        folder: Its working folder; by default that of this process.

    Raises:
        RuntimeError: It did not start.
    """
    command = [sys.executable, *program, "--port", "0", "--map", town, "--exit-on-stdin-eof"]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log, text=True, cwd=folder
    ) as process:
        try:
            ready = READY.search(process.stdout.readline() if process.stdout else "")
            if ready is None:
                raise RuntimeError("the server did not start; see its message")
            yield int(ready[1]), process
        finally:
            process.terminate()


def synchronous_manager(client: carla.Client, port: int, seed: int) -> carla.TrafficManager:
    """Return a traffic manager at the port, for a synchronous world."""
    manager = client.get_trafficmanager(port)
    manager.set_synchronous_mode(True)
    manager.set_random_device_seed(seed)
    return manager


def spawn_shuffled(world: carla.World, count: int, seed: int) -> list[Any]:
    """Return up to `count` cars, at spawn points drawn with the seed."""
    blueprint = world.get_blueprint_library().find(CAR)
    spots = world.get_map().get_spawn_points()
    random.Random(seed).shuffle(spots)
    spawned = (world.try_spawn_actor(blueprint, spot) for spot in spots)
    return [car for _, car in zip(range(count), (item for item in spawned if item is not None), strict=False)]


def listen(world: carla.World, car: Any, type_id: str, attributes: dict[str, int]) -> tuple[Any, Queue[int]]:
    """Attach a sensor to a car; return it, and a queue of the frames of its measurements.

    Keep the sensor: without a reference it is stopped.
    """
    import carla

    blueprint = world.get_blueprint_library().find(type_id)
    for key, value in attributes.items():
        blueprint.set_attribute(key, str(value))
    queue: Queue[int] = Queue()
    sensor = world.spawn_actor(blueprint, carla.Transform(carla.Location(x=0.5, z=2.4)), attach_to=car)
    sensor.listen(lambda data: queue.put(data.frame))
    return sensor, queue


def free_port() -> int:
    """Return a free port. Another benchmark on this machine may use any fixed one."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
