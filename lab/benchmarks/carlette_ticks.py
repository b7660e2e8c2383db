"""Ticks per second of carlette with the real client, empty and with traffic.

Each metric is also given as a ratio to the same loop in an empty world without a traffic manager, so that runs on
different machines can be compared. A traffic manager makes the server pace its snapshots. A server whose world does not
change shows the cost of the client and the sockets alone: no server in Python can be faster.
"""

from __future__ import annotations

import multiprocessing
import statistics
import time
from typing import Any

from lab.benchmarks.carlette_clients import CAR, PROGRAM, STEP_S, running_server, synchronous_manager
from stucksolver_eval.simulator_server import set_synchronous

WARM_UP_TICKS = 40
"""Number of ticks before the measurement."""
MANAGER_PORT = 8765
"""Port of the traffic manager."""
LONGEST_RUN_S = 120.0
"""Time after which a client counts as hanging (s)."""
FLEETS = (0, 20, 50)
"""Numbers of cars."""
ROUNDS = 3
"""Number of rounds whose median counts."""
STANDING_STILL = """
from carlette import cli, simulator
def tick(self):
    self.world.frame += 1
    self.world.elapsed_s += 0.05
    return self.world.frame
simulator.Simulator.tick = tick
cli.main()
"""
"""A server that sends snapshots but computes nothing."""


def run(smoke: bool) -> dict[str, float]:
    """Return the medians of several rounds.

    They are `ticks_per_s_*` with an unchanged world, unpaced, and with 0, 20 and 50 cars, and `ratio_*` of each
    to `ticks_per_s_unpaced`.
    """
    ticks, rounds = (100, 1) if smoke else (1500, ROUNDS)
    loops: dict[str, tuple[int | None, tuple[str, ...]]] = {
        "standing_still": (None, ("-c", STANDING_STILL)),
        "unpaced": (None, PROGRAM),
        **{f"{cars}_cars": (cars, PROGRAM) for cars in FLEETS},
    }
    rates: dict[str, list[float]] = {name: [] for name in loops}
    for _ in range(rounds):
        for name, (cars, program) in loops.items():
            rates[name].append(_measure(cars, ticks, program))
    medians = {name: statistics.median(found) for name, found in rates.items()}
    ratios = {f"ratio_{name}": rate / medians["unpaced"] for name, rate in medians.items() if name != "unpaced"}
    return {f"ticks_per_s_{name}": rate for name, rate in medians.items()} | ratios


def _measure(cars: int | None, ticks: int, program: tuple[str, ...]) -> float:
    """Return ticks per second. The client runs in its own process and is killed if it hangs.

    Raises:
        RuntimeError: The client returns no result.
    """
    context = multiprocessing.get_context("spawn")
    with running_server(program=program) as (port, _):
        receiver, sender = context.Pipe(duplex=False)
        client = context.Process(target=_drive, args=(port, cars, ticks, sender), daemon=True)
        client.start()
        sender.close()
        try:
            if not receiver.poll(LONGEST_RUN_S):
                raise RuntimeError(f"the client with {cars} cars did not finish within {LONGEST_RUN_S:g} s")
            return float(receiver.recv())
        except EOFError:
            raise RuntimeError(f"the client with {cars} cars returned no result; see its messages") from None
        finally:
            client.kill()
            client.join()


def _drive(port: int, cars: int | None, ticks: int, result: Any) -> None:
    """Connect, spawn `cars` under a traffic manager (None: no manager either), tick, and send the rate."""
    import carla

    client = carla.Client("127.0.0.1", port)
    client.set_timeout(20.0)
    world = client.get_world()
    set_synchronous(world, STEP_S)
    if cars is not None:
        synchronous_manager(client, MANAGER_PORT, seed=1)
        for car in spawn_cars(world, cars):
            car.set_autopilot(True, MANAGER_PORT)
    for _ in range(WARM_UP_TICKS):
        world.tick()
    start = time.perf_counter()
    for _ in range(ticks):
        world.tick()
    result.send(ticks / (time.perf_counter() - start))


def spawn_cars(world: Any, count: int) -> list[Any]:
    blueprint = world.get_blueprint_library().find(CAR)
    cars: list[Any] = []
    for spot in world.get_map().get_spawn_points():
        car = world.try_spawn_actor(blueprint, spot) if len(cars) < count else None
        if car is not None:
            cars.append(car)
    if len(cars) < count:
        raise RuntimeError(f"too few spawn points: {len(cars)} cars of {count} could be spawned")
    world.tick()
    return cars
