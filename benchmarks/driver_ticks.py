"""What each of our drivers takes to decide a tick among 20 cars, in milliseconds: its whole `run_step`.

Both drive the same street of carlette's demo town among cars of the TrafficManager, with the real client. Reading the
snapshot is part of it; the first second is left out, in which sizes of actors are asked for once.
"""

from __future__ import annotations

import multiprocessing
import statistics
from typing import Any

import carla

from benchmarks.addon_overhead import STEP_S, Times, busy_town
from benchmarks.carlette_ticks import LONGEST_RUN_S
from stucksolver.stacks.driver import BehaviorDriver
from stucksolver.stacks.planner import PlannerDriver
from stucksolver_eval.server import carlette_server

DRIVERS = {"behavior": BehaviorDriver, "planner": PlannerDriver}
FIRST_S = 1.0


def run(smoke: bool) -> dict[str, float]:
    """Median, 99th percentile and worst of each driver (ms)."""
    ticks = 100 if smoke else 800
    return {f"{name}_{what}": value for name in DRIVERS for what, value in _apart(name, ticks).items()}


def _apart(name: str, ticks: int) -> dict[str, float]:
    """In a process of its own: threads of the TrafficManager outlive the server, and end their process then."""
    context = multiprocessing.get_context("spawn")
    with carlette_server("demo_town") as server:
        receiver, sender = context.Pipe(duplex=False)
        client = context.Process(target=_drive, args=(server.host, server.port, name, ticks, sender), daemon=True)
        client.start()
        sender.close()
        try:
            if not receiver.poll(LONGEST_RUN_S):
                raise RuntimeError(f"the client did not finish within {LONGEST_RUN_S:g} s")
            figures: dict[str, float] = receiver.recv()
        except EOFError:
            raise RuntimeError("the client ended without a figure; see its messages") from None
        finally:
            client.kill()
            client.join()
    return figures


def _drive(host: str, port: int, name: str, ticks: int, result: Any) -> None:
    client = carla.Client(host, port)
    client.set_timeout(20.0)
    world, ego, goal = busy_town(client)
    driver = DRIVERS[name](ego, carla_map=world.get_map())
    driver.set_destination(goal)
    times = Times()
    for tick in range(ticks):
        part = "first" if tick * STEP_S < FIRST_S else "step"
        ego.apply_control(times.take(part, driver.run_step))
        world.tick()
        if driver.done():
            break
    steps = [1e-3 * one for one in times["step"]]
    result.send(
        {"ms": statistics.median(steps), "p99_ms": statistics.quantiles(steps, n=100)[98], "worst_ms": max(steps)}
    )
