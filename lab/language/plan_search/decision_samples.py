"""Samples of drives without recovery, in one compressed file per drive.

A sample has the scene, the time until the driver went on by itself, and the plans that the guard would have accepted.
"""

from __future__ import annotations

import gzip
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
from stucksolver.reasoners.rules import RuleReasoner

from lab.language.plan_search.ego_trajectory import EgoTrajectory, begin, drive, moved
from lab.language.plan_search.quick_value import QuickValue
from stucksolver.atomic_files import write_bytes
from stucksolver.guard import Guard
from stucksolver.plan import Decision, RecoveryPlan
from stucksolver.reasoners.reasoner import ReasonerRequest
from stucksolver.record import LoggedQuery
from stucksolver.scene import Scene, Surroundings
from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.execution import Execution
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_language.student.candidates import candidates
from stucksolver_language.student.scene_codec import write_scene

GONE_ON_M = 5.0
"""New progress that ends a standstill (m): the detector's own measure of progress in its window."""
STARTED_M = 0.5
"""Distance from the stop at which the driver counts as having gone on (m). Ours."""
JUDGED_AFTER_S = (0.0, 10.0, 30.0)
"""Times of a standstill from which on plans are judged, at the first sample (s). Ours."""
SUFFIX = ".jsonl.gz"


class JudgedPlan(FrozenModel):
    """A plan, the guard's verdict at this sample, and, if accepted, its quick value (m)."""

    plan: RecoveryPlan
    value_m: float | None


class DecisionSample(FrozenModel):
    """One sample of a standstill in a drive with the driver alone.

    Attributes:
        suite: Name of the suite.
        route_id: The route within it.
        seed: Seed of the traffic.
        scenario: Type of the route's first scenario. It is for splits and labels, and never part of the scene.
        town: The map.
        standstill: Number of the standstill in this drive, from 0.
        at_s: Time since the start of the route (s).
        scene: The scene as text of `scene_text.VERSION`.
        gone_after_s: Time until the driver went on by itself (s); None if it did not in the observed time.
        watched_s: Observed time of the drive from here (s).
        answer: The answer of a reasoner there, from a record; None in a drive of the driver alone.
        plans: All candidate plans with the guard's verdict; empty if they were not judged at this sample.
    """

    version: int = 1
    """Version of the file."""
    suite: str
    route_id: str
    seed: int
    scenario: str
    town: str
    standstill: int
    at_s: float
    scene: str
    gone_after_s: float | None
    watched_s: float
    answer: Decision | None = None
    plans: tuple[JudgedPlan, ...] = ()


def moments_of(suite: str, outcome: RouteOutcome, asked: Sequence[LoggedQuery], guard: Guard) -> list[DecisionSample]:
    """Return the samples of a drive: one for each query of the reasoner.

    Args:
        suite: Name of the suite.
        outcome: The outcome of the drive.
        asked: Its queries, in order.
        guard: The guard that judges the candidate plans.
    """
    found: list[DecisionSample] = []
    track = np.array(outcome.track, np.float64).reshape(-1, 2)
    number, place_m, began_s, judged = -1, -np.inf, 0.0, 0
    # The log of queries counts simulation time; the drive's record counts from the start of the route.
    for question in asked:
        at_s = outcome.queries[question.number - 1].asked_s
        here_m = float(np.interp(at_s, track[:, 0], track[:, 1]))
        if here_m > place_m + GONE_ON_M:
            number, place_m, began_s, judged = number + 1, here_m, at_s, 0
        due = judged < len(JUDGED_AFTER_S) and at_s >= began_s + JUDGED_AFTER_S[judged]
        surroundings = question.surroundings if due else None
        judged += due
        found.append(
            DecisionSample(
                suite=suite,
                route_id=outcome.route_id,
                seed=outcome.seed,
                scenario=outcome.scenario,
                town=outcome.town,
                standstill=number,
                at_s=round(at_s, 2),
                scene=write_scene(question.scene),
                gone_after_s=gone_after(track, at_s),
                watched_s=round(max(float(track[-1, 0]) - at_s, 0.0), 2),
                plans=() if surroundings is None else tuple(judge(question.scene, surroundings, guard)),
            )
        )
    return found


def gone_after(track: np.ndarray[tuple[int, ...], np.dtype[np.float64]], at_s: float) -> float | None:
    """Return the time from `at_s` until the vehicle went on (s), or None if it did not.

    Args:
        track: Times (s) and positions along the route (m), ascending, (n, 2).
        at_s: The time of the sample (s).
    """
    t, place = track[:, 0], track[:, 1]
    here_m = float(np.interp(at_s, t, place))
    later = (t > at_s) & (place >= here_m + GONE_ON_M)
    if not later.any():
        return None
    arrived = int(np.argmax(later))
    before = np.flatnonzero((np.arange(len(t)) < arrived) & ((place <= here_m + STARTED_M) | (t <= at_s)))
    last = int(before[-1])
    rise = place[last + 1] - max(place[last], here_m)
    share = STARTED_M / rise if rise > STARTED_M else 1.0
    started_s = max(t[last], at_s) + share * (t[last + 1] - max(t[last], at_s))
    return round(max(float(started_s) - at_s, 0.0), 2)


def judge(scene: Scene, surroundings: Surroundings, guard: Guard) -> Iterator[JudgedPlan]:
    """Yield the candidate plans of a scene, with the guard's verdict in these surroundings."""
    view, glance = FrenetScene(surroundings), QuickValue(surroundings)
    # The answers of a drive that only waits have no plans, so the rules are queried here.
    own = RuleReasoner().decide(ReasonerRequest(scene)).decision.plan
    for plan in dict.fromkeys((*candidates(scene), *(() if own is None else (own,)))):
        accepted = Execution(plan, guard, guided=False).start(view, scene.time_s).accepted
        trail = _trail(plan, surroundings, guard) if accepted else None
        yield JudgedPlan(plan=plan, value_m=None if trail is None else round(glance.value(trail), 2))


def _trail(plan: RecoveryPlan, surroundings: Surroundings, guard: Guard) -> EgoTrajectory | None:
    """Return the trajectory of an accepted plan; None if a later part cannot be driven from its start."""
    trail = begin(surroundings)
    for behavior in plan.behaviors:
        if behavior.stands_still:
            continue
        view = FrenetScene(moved(surroundings, trail))
        verdict, proven = guard.accept((behavior,), view, guided=False)
        if proven is None or not verdict.accepted:
            return None
        trail = drive(trail, proven, view)
    return trail


def write_moments(path: Path, moments: Iterable[DecisionSample]) -> None:
    """Write the samples of one drive.

    Raises:
        OutputError: The file cannot be written.
    """
    lines = "".join(sample.model_dump_json() + "\n" for sample in moments)
    write_bytes(path, gzip.compress(lines.encode("utf-8"), mtime=0))


def read_moments(path: Path) -> list[DecisionSample]:
    """Return the samples of one drive.

    Raises:
        ValueError: The file is damaged, or of another version. The message has its name.
    """
    try:
        text = gzip.decompress(path.read_bytes()).decode("utf-8")
        return [DecisionSample.model_validate_json(line) for line in text.splitlines()]
    except (OSError, EOFError, ValueError) as error:
        raise ValueError(f"cannot read samples: {path} ({error}). Remove the file, and collect it again") from error
