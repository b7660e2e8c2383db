"""Real-time factor of carlette at 20 Hz with 20 cars of the TrafficManager and sensors on one of them.

The client waits for every measurement in every tick, as evaluators do. Each sensor set gets its own server.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from pathlib import Path
from typing import Any

from lab.benchmarks.carlette_clients import STEP_S, listen, running_server, synchronous_manager
from lab.benchmarks.carlette_ticks import LONGEST_RUN_S, MANAGER_PORT, spawn_cars
from stucksolver_eval.simulator_server import set_synchronous

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
                moments.append((receiver.recv(), _processor_s(server.pid)))
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
    set_synchronous(world, STEP_S)
    synchronous_manager(client, MANAGER_PORT, seed=1)
    cars = spawn_cars(world, CARS)
    for car in cars:
        car.set_autopilot(True, MANAGER_PORT)
    sensors = [listen(world, cars[0], type_id, attributes) for type_id, attributes in SETS[name]]
    measuring = [queue for sensor, queue in sensors if "collision" not in sensor.type_id]
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
