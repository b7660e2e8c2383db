"""How much faster than real time carlette runs at 20 Hz with 20 cars of the TrafficManager and sensors on one of them.

The client waits for every measurement in every tick, as evaluators do. Each set of sensors gets a server of its own.
"""

from __future__ import annotations

import multiprocessing
import time
from queue import Queue
from typing import Any

from benchmarks.carlette_ticks import LONGEST_RUN_S, MANAGER_PORT, STEP_S, running_server, spawn_cars

CARS = 20
WARM_UP_TICKS = 20
LONGEST_WAIT_S = 20.0
CAMERA = ("sensor.camera.rgb", {"image_size_x": 800, "image_size_y": 450, "fov": 90})
LIDAR = (
    "sensor.lidar.ray_cast",
    {"channels": 64, "range": 100, "points_per_second": 1_310_720, "rotation_frequency": 20},
)
SMALL = tuple((f"sensor.other.{one}", dict[str, int]()) for one in ("gnss", "imu", "radar", "collision"))
SETS = {"none": (), "camera": (CAMERA,), "lidar": (LIDAR,), "camera_and_lidar": (CAMERA, LIDAR, *SMALL)}


def run(smoke: bool) -> dict[str, float]:
    """The figures: `real_time_factor_*` (simulated seconds in a second) for each set of sensors."""
    ticks = 40 if smoke else 600
    return {f"real_time_factor_{name}": _measure(name, ticks) for name in SETS}


def _measure(name: str, ticks: int) -> float:
    """The client runs in a process of its own and is ended where it hangs; raises `RuntimeError` without a figure."""
    context = multiprocessing.get_context("spawn")
    with running_server() as port:
        receiver, sender = context.Pipe(duplex=False)
        client = context.Process(target=_drive, args=(port, name, ticks, sender), daemon=True)
        client.start()
        sender.close()
        try:
            if not receiver.poll(LONGEST_RUN_S):
                raise RuntimeError(f"the client with sensors '{name}' did not finish within {LONGEST_RUN_S:g} s")
            return float(receiver.recv())
        except EOFError:
            raise RuntimeError(f"the client with sensors '{name}' ended without a figure; see its messages") from None
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
    measuring = [one for one, (type_id, _) in zip(queues, SETS[name], strict=True) if "collision" not in type_id]
    start = 0.0
    for tick in range(WARM_UP_TICKS + ticks):
        if tick == WARM_UP_TICKS:
            start = time.perf_counter()
        frame = world.tick()
        for queue in measuring:
            if queue.get(timeout=LONGEST_WAIT_S) != frame:
                raise RuntimeError(f"a measurement of another frame than {frame} came with it")
    result.send(ticks * STEP_S / (time.perf_counter() - start))


def _listen(carla: Any, world: Any, car: Any, type_id: str, attributes: dict[str, int]) -> Queue[int]:
    blueprint = world.get_blueprint_library().find(type_id)
    for key, value in attributes.items():
        blueprint.set_attribute(key, str(value))
    queue: Queue[int] = Queue()
    sensor = world.spawn_actor(blueprint, carla.Transform(carla.Location(x=0.5, z=2.4)), attach_to=car)
    sensor.listen(lambda data: queue.put(data.frame))
    queue.sensor = sensor  # type: ignore[attr-defined]  # a sensor that nobody holds is stopped
    return queue
