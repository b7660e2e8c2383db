"""Time of the whole add-on per tick in free driving, compared with the driver itself.

The built-in driver drives through carlette's demo town among 20 cars of the TrafficManager. Every part is timed on
every tick, with the real client. The add-on is the stack's status (route projection, tracker) and `StuckSolver.step`.
"""

from __future__ import annotations

import multiprocessing
import statistics
import time
from collections.abc import Callable
from typing import Any, TypeVar

import carla

from lab.benchmarks.carlette_clients import free_port, synchronous_manager
from lab.benchmarks.carlette_ticks import LONGEST_RUN_S
from stucksolver.solver import StuckSolver
from stucksolver_carla.drivers.behavior import BehaviorDriver
from stucksolver_carla.stack import CarlaStack
from stucksolver_eval.simulator_server import carlette_server, set_synchronous
from stucksolver_eval.streets.finder import choose_street

CARS = 20
"""Number of cars of the TrafficManager."""
STEP_S = 0.05
"""Step of the simulation (s)."""
T = TypeVar("T")


def run(smoke: bool) -> dict[str, float]:
    """Return medians and 99th percentiles in microseconds, and the ratio of the add-on's time to the driver's."""
    return in_own_process(_measured, 100 if smoke else 600)


def in_own_process(measure: Callable[..., dict[str, float]], *arguments: Any) -> dict[str, float]:
    """Return the result of `measure(client, *arguments)`, with a server on the demo town.

    The call runs in a separate process: threads of the TrafficManager outlive the server, and end their process then.
    `measure` is a function of a module.

    Raises:
        RuntimeError: The call takes too long or ends without a result.
    """
    context = multiprocessing.get_context("spawn")
    with carlette_server("demo_town") as server:
        receiver, sender = context.Pipe(duplex=False)
        process_arguments = (server.host, server.port, measure, arguments, sender)
        client = context.Process(target=_apart, args=process_arguments, daemon=True)
        client.start()
        sender.close()
        try:
            if not receiver.poll(LONGEST_RUN_S):
                raise RuntimeError(f"the client did not finish within {LONGEST_RUN_S:g} s")
            figures: dict[str, float] = receiver.recv()
        except EOFError:
            raise RuntimeError("the client ended without a result; see its messages") from None
        finally:
            client.kill()
            client.join()
    return figures


def _apart(
    host: str, port: int, measure: Callable[..., dict[str, float]], arguments: tuple[Any, ...], result: Any
) -> None:
    client = carla.Client(host, port)
    client.set_timeout(20.0)
    result.send(measure(client, *arguments))


def _measured(client: carla.Client, ticks: int) -> dict[str, float]:
    return _figures(_drive(client, ticks))


class Times(dict[str, list[float]]):
    """Durations in microseconds by name."""

    def take(self, name: str, call: Callable[[], T]) -> T:
        start = time.perf_counter()
        result = call()
        self.setdefault(name, []).append(1e6 * (time.perf_counter() - start))
        return result


def busy_town(client: carla.Client) -> tuple[carla.World, carla.Vehicle, carla.Location]:
    """Return a synchronous world with `CARS` cars of the TrafficManager, a stopped ego in a street, and its goal."""
    world = client.get_world()
    set_synchronous(world, STEP_S)
    carla_map = world.get_map()
    site = choose_street(carla_map, "one_lane", 1, 260)
    library = world.get_blueprint_library()
    place = site.start.transform
    place.location.z += 0.3
    ego = world.spawn_actor(library.find("vehicle.lincoln.mkz_2020"), place)
    model = library.find("vehicle.tesla.model3")
    spots = [s for s in carla_map.get_spawn_points() if s.location.distance(place.location) > 15.0]
    cars = [car for car in (world.try_spawn_actor(model, spot) for spot in spots[: 2 * CARS]) if car][:CARS]
    world.tick()
    manager = synchronous_manager(client, free_port(), seed=1)
    for car in cars:
        car.set_autopilot(True, manager.get_port())
    return world, ego, site.destination.transform.location


def _drive(client: carla.Client, ticks: int) -> Times:
    world, ego, goal = busy_town(client)
    carla_map = world.get_map()
    driver = BehaviorDriver(ego, carla_map=carla_map)
    driver.set_destination(goal)
    stack = CarlaStack(ego, driver, carla_map)
    times = Times()
    with StuckSolver(stack.scene, clock="lockstep") as solver:
        for _ in range(ticks):
            status = times.take("status", stack.status)
            directive = times.take("step", lambda status=status: solver.step(status, stack.surroundings))  # type: ignore[misc]
            ego.apply_control(times.take("driver", lambda directive=directive: stack.perform(directive)))  # type: ignore[misc]
            world.tick()
            if status.at_destination:
                break
    return times


def _figures(times: Times) -> dict[str, float]:
    addon = [a + b for a, b in zip(times["status"], times["step"], strict=True)]
    figures = {f"{name}_us": statistics.median(values) for name, values in times.items()}
    figures["addon_us"] = statistics.median(addon)
    figures["addon_p99_us"] = statistics.quantiles(addon, n=100)[98]
    figures["ratio_addon_to_driver"] = statistics.median(addon) / figures["driver_us"]
    return figures
