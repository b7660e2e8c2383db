"""Real-time factor of carlette at 20 Hz with 20 cars of the TrafficManager and sensors on one of them.

The client waits for every measurement in every tick, as evaluators do. Each sensor set gets its own server.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from pathlib import Path
from queue import Queue
from typing import TYPE_CHECKING, Any

from lab.benchmarks.carlette_ticks import LONGEST_RUN_S, MANAGER_PORT, STEP_S, running_server, spawn_cars

if TYPE_CHECKING:
    import carla

CARS = 20
"""Number of cars of the TrafficManager."""
WARM_UP_TICKS = 20
"""Number of ticks before the measurement."""
LONGEST_WAIT_S = 20.0
"""Time to wait for one measurement (s)."""
CAMERA = ("sensor.camera.rgb", {"image_size_x": 800, "image_size_y": 450, "fov": 90})
"""A camera: blueprint and attributes."""
LIDAR = (
    "sensor.lidar.ray_cast",
    {"channels": 64, "range": 100, "points_per_second": 1_310_720, "rotation_frequency": 20},
)
"""A LiDAR: blueprint and attributes."""
SMALL = tuple((f"sensor.other.{text}", dict[str, int]()) for text in ("gnss", "imu", "radar", "collision"))
SETS = {"none": (), "camera": (CAMERA,), "lidar": (LIDAR,), "camera_and_lidar": (CAMERA, LIDAR, *SMALL)}


def run(smoke: bool) -> dict[str, float]:
    """Return the metrics for each set of sensors.

    `real_time_factor_*`: simulated seconds per second. `server_ms_*`: the server's CPU time per tick over all threads,
    which other programs on the machine affect less.
    """
    # A smoke test uses the set that contains all sensors.
    ticks, sets = (20, [*SETS][-1:]) if smoke else (600, [*SETS])
    figures = {}
    for name in sets:
        figures[f"real_time_factor_{name}"], figures[f"server_ms_{name}"] = _measure(name, ticks)
    return figures


def _measure(name: str, ticks: int) -> tuple[float, float]:
    """Run the client in its own process, and kill it if it hangs.

    Raises:
        RuntimeError: The client returns no result.
    """
    context = multiprocessing.get_context("spawn")
    with running_server() as (port, server):
        receiver, sender = context.Pipe(duplex=False)
        client = context.Process(target=_drive, args=(port, name, ticks, sender), daemon=True)
        client.start()
        sender.close()
        try:
            moments = []
            for _ in range(2):  # after warming up, and at the end
                if not receiver.poll(LONGEST_RUN_S):
                    raise RuntimeError(f"the client with sensors '{name}' did not finish within {LONGEST_RUN_S:g} s")
                moments.append((receiver.recv(), _processor_s(server)))
            (start, before), (end, after) = moments
            return ticks * STEP_S / (end - start), 1e3 * (after - before) / ticks
        except EOFError:
            raise RuntimeError(f"the client with sensors '{name}' returned no result; see its messages") from None
        finally:
            client.kill()
            client.join()


def _drive(port: int, name: str, ticks: int, result: Any) -> None:
    import carla

    client = carla.Client("127.0.0.1", port)
    client.set_timeout(60.0)
    world = client.get_world()
    settings = world.get_settings()
    settings.synchronous_mode, settings.fixed_delta_seconds = True, STEP_S
    world.apply_settings(settings)
    manager = client.get_trafficmanager(MANAGER_PORT)
    manager.set_synchronous_mode(True)
    manager.set_random_device_seed(1)
    cars = spawn_cars(world, CARS)
    for car in cars:
        car.set_autopilot(True, MANAGER_PORT)
    queues = [_listen(carla, world, cars[0], type_id, attributes) for type_id, attributes in SETS[name]]
    measuring = [item for item, (type_id, _) in zip(queues, SETS[name], strict=True) if "collision" not in type_id]
    for tick in range(WARM_UP_TICKS + ticks):
        if tick == WARM_UP_TICKS:
            result.send(time.perf_counter())
        frame = world.tick()
        for queue in measuring:
            if queue.get(timeout=LONGEST_WAIT_S) != frame:
                raise RuntimeError(f"a measurement is not of frame {frame}")
    result.send(time.perf_counter())


def _processor_s(pid: int) -> float:
    """Return the CPU time of a process on this machine (s)."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _listen(carla: Any, world: carla.World, car: Any, type_id: str, attributes: dict[str, int]) -> Queue[int]:
    blueprint = world.get_blueprint_library().find(type_id)
    for key, value in attributes.items():
        blueprint.set_attribute(key, str(value))
    queue: Queue[int] = Queue()
    sensor = world.spawn_actor(blueprint, carla.Transform(carla.Location(x=0.5, z=2.4)), attach_to=car)
    sensor.listen(lambda data: queue.put(data.frame))
    queue.sensor = sensor  # type: ignore[attr-defined]  # a sensor without a reference is stopped
    return queue
