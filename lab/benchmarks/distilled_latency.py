"""Time of one decision of the student among 30 objects, with the guard's verdicts on its plans, on one core.

`ms_*` are milliseconds of wall time at the 50th and the 95th percentile. `over_rules_*` are the same as multiples of
the times of the rules for the same scenes in the same run, which other load changes less.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator

from lab.benchmarks.solver_overhead import parked_car
from stucksolver.guard import Guard
from stucksolver.ladder import find_ladder
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import REGISTRY, describe
from stucksolver.reasoners import Reasoner, ReasonerRequest, RuleReasoner
from stucksolver.scene import Status
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.scene_builder import build_scene
from stucksolver.solver.state_machine.admission import preview_verdict
from stucksolver_language.student import DistilledReasoner

MOVED_M = 0.25
"""Distance by which the ego is moved back between two queries (m), so that no query is a repetition."""


def run(smoke: bool) -> dict[str, float]:
    """Return the metrics of this module's docstring."""
    asked = list(questions(20 if smoke else 200))
    rules, student = _times(RuleReasoner(), asked), _times(DistilledReasoner(), asked)
    figures: dict[str, float] = {}
    for name, number in (("p50", 49), ("p95", 94)):
        theirs, ours = (statistics.quantiles(times, n=100)[number] for times in (rules, student))
        figures |= {f"ms_{name}": ours * 1e3, f"over_rules_{name}": ours / theirs}
    return figures


def _times(reasoner: Reasoner, asked: list[ReasonerRequest]) -> list[float]:
    """Return the times of the queries (s), after one query that loads the weights."""
    reasoner.decide(asked[0])
    times = []
    for request in asked:
        began = time.perf_counter()
        reasoner.decide(request)
        times.append(time.perf_counter() - began)
    return times


def questions(count: int) -> Iterator[ReasonerRequest]:
    """Yield queries about a car parked in the lane, among 30 objects, each with a check of plans by the guard."""
    guard = Guard(find_ladder("evaluation").guard_policy())
    first = parked_car()
    for number in range(count):
        ego = first.ego.model_copy(update={"x_m": first.ego.x_m - MOVED_M * (number % 20)})
        surroundings = first.model_copy(update={"ego": ego, "frame": first.frame + number})
        view = FrenetScene(surroundings)
        status = Status(time_s=surroundings.time_s, speed_mps=0.0, progress_m=0.0)
        scene = build_scene(view, status, describe(tuple(REGISTRY)))
        scene = scene.model_copy(update={"ego": scene.ego.model_copy(update={"stopped_for_s": 30.0 + number})})

        def check(plan: RecoveryPlan, view: FrenetScene = view, now_s: float = surroundings.time_s) -> str:
            return preview_verdict(plan, view, now_s, guard=guard, guided=False)

        yield ReasonerRequest(scene, check)
