"""Time of one decision of the search among 30 objects, with all checks by the guard, on one core.

There are three situations: a plan is found on the grid (`pass`), only after a move that gives room (`room`), and not
at all (`none`: the oncoming lane is not visible). `ms_*` are milliseconds of wall time at the 50th and the 95th
percentile, `checks_*` is the median number of steps that the guard checked, and `over_accept_*` is the median as a
multiple of one acceptance of a pass in the same run, which other load changes less.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

from lab.benchmarks.solver_overhead import parked_car
from stucksolver.guard import Guard
from stucksolver.ladder import find_ladder
from stucksolver.plan.behaviors import REGISTRY, BorrowOncomingLane, describe
from stucksolver.reasoners import ReasonerRequest
from stucksolver.reasoners.search import SearchReasoner
from stucksolver.scene import LaneSight, Status, Surroundings
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.scene_builder import build_scene
from stucksolver.solver.state_machine.plan_preview import PlanPreview

STEP_M = 0.05
"""Distance by which the ego is moved back between two decisions (m), so that none is a repetition."""
NEARER_M = 5.0
"""Distance by which the ego is nearer to the parked car where it has no room to pull out (m)."""
SIGHT_M = 45.0
"""Sight distance at which no pass is possible (m)."""


def run(smoke: bool) -> dict[str, float]:
    """Return the metrics of this module's docstring."""
    count, first = (5, parked_car()) if smoke else (60, parked_car())
    lanes = tuple(LaneSight(lane_id=x.lane_id, ahead_m=SIGHT_M, behind_m=SIGHT_M) for x in first.sight)
    situations = {
        "pass": first,
        "room": _moved(first, NEARER_M),
        "none": first.model_copy(update={"sight": lanes}),
    }
    guard = Guard(find_ladder("evaluation").guard_policy())
    view, plan = FrenetScene(first), (BorrowOncomingLane(past_object_id="lead", speed_mps=5.0),)
    accepts = [_timed(lambda: guard.accept(plan, view, guided=False)) for _ in range(count)]
    figures: dict[str, float] = {}
    for name, surroundings in situations.items():
        pairs = [_decide(guard, _moved(surroundings, -STEP_M * k)) for k in range(count)]
        times, checks = [took for took, _ in pairs], [number for _, number in pairs]
        figures[f"ms_{name}_p50"] = statistics.median(times) * 1e3
        figures[f"ms_{name}_p95"] = statistics.quantiles(times, n=20)[18] * 1e3
        figures[f"checks_{name}"] = statistics.median(checks)
        figures[f"over_accept_{name}"] = statistics.median(times) / statistics.median(accepts)
    return figures


def _timed(call: Callable[[], object]) -> float:
    began = time.perf_counter()
    call()
    return time.perf_counter() - began


def _moved(surroundings: Surroundings, by_m: float) -> Surroundings:
    ego = surroundings.ego.model_copy(update={"x_m": surroundings.ego.x_m + by_m})
    return surroundings.model_copy(update={"ego": ego})


def _decide(guard: Guard, surroundings: Surroundings) -> tuple[float, int]:
    """Return the time of a decision (s), and the number of steps that the guard checked."""
    view = FrenetScene(surroundings)
    status = Status(time_s=surroundings.time_s, speed_mps=0.0, progress_m=0.0)
    scene = build_scene(view, status, describe(tuple(REGISTRY)))
    scene = scene.model_copy(update={"ego": scene.ego.model_copy(update={"stopped_for_s": 30.0})})
    preview = PlanPreview(guard, view, lambda plan: False)
    request = ReasonerRequest(scene, assess=preview.assess)
    return _timed(lambda: SearchReasoner().decide(request)), preview.checks
