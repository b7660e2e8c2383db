"""Time of one `run_step` of each built-in driver among 20 cars, in milliseconds.

Both drive the same street of carlette's demo town among cars of the TrafficManager, with the real client. The times
include reading the snapshot. They exclude the first second, in which the sizes of actors are requested once.
"""

from __future__ import annotations

import statistics

import carla

from lab.benchmarks.addon_overhead import STEP_S, Times, busy_town, in_own_process
from stucksolver_carla.drivers.behavior import BehaviorDriver
from stucksolver_carla.drivers.planner import PlannerDriver

DRIVERS = {"behavior": BehaviorDriver, "planner": PlannerDriver}
FIRST_S = 1.0
"""Time at the start that is not measured (s)."""


def run(smoke: bool) -> dict[str, float]:
    """Return median, 99th percentile and maximum of each driver (ms)."""
    ticks = 40 if smoke else 800
    return {
        f"{name}_{what}": value for name in DRIVERS for what, value in in_own_process(_measured, name, ticks).items()
    }


def _measured(client: carla.Client, name: str, ticks: int) -> dict[str, float]:
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
    steps = [1e-3 * time for time in times["step"]]
    return {"ms": statistics.median(steps), "p99_ms": statistics.quantiles(steps, n=100)[98], "worst_ms": max(steps)}
