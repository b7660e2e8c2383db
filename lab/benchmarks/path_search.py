"""Time of the path search relative to one verdict of the guard, in the benchmark's street with 30 road users.

Both are medians of the thread's CPU time, measured in the same run. `out` is the swing-out of a pass, `pass` a whole
pass with its return, `turned` the path of a turned vehicle back to its lane, and `none` the search before it reports
that no path exists, with the distance to back up.
"""

from __future__ import annotations

import contextlib
from functools import partial

from lab.benchmarks.solver_overhead import median_us, parked_car
from stucksolver.guard import Guard
from stucksolver.plan.behaviors import BehaviorStart, BorrowOncomingLane, NoPathError
from stucksolver.plan.path_search import Goal, search_path
from stucksolver.scene import Surroundings
from stucksolver.scene.frenet_scene import FrenetScene

SEARCHES = {
    "out": (BehaviorStart(60.0, 0.0, 0.0), Goal(2.9, 110.0)),
    "pass": (BehaviorStart(60.0, 0.0, 0.0), Goal(0.0, 110.0, 80.0)),
    "turned": (BehaviorStart(90.0, 0.8, 0.0, 0.3), Goal(0.0, 140.0)),
    "none": (BehaviorStart(68.5, 0.0, 0.0), Goal(2.9, 110.0)),
}


def run(smoke: bool) -> dict[str, float]:
    """Return `us_*`, microseconds for each search and for a verdict, and `ratio_*`, their ratio to the verdict."""
    batches, calls = (3, 1) if smoke else (40, 3)
    surroundings, guard = parked_car(), Guard()
    plan = [BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)]
    figures = {
        "us_accept": median_us(batches, calls, lambda: guard.accept(plan, FrenetScene(surroundings), guided=False))
    }
    for name, (start, goal) in SEARCHES.items():
        search = partial(_searched, surroundings, start, goal)
        figures[f"us_{name}"] = median_us(batches, calls, search)
        figures[f"ratio_{name}"] = figures[f"us_{name}"] / figures["us_accept"]
    return figures


def _searched(surroundings: Surroundings, start: BehaviorStart, goal: Goal) -> None:
    """Search once, in a new view, because the results of a tick are kept."""
    with contextlib.suppress(NoPathError):
        search_path(FrenetScene(surroundings), start, goal)
