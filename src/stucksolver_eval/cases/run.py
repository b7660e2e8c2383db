"""Drives the cases: from the scene through the reasoner and the guard to the drive."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from stucksolver.ladder import parse_ladder, profile_text
from stucksolver.solver import Event, EventKind
from stucksolver_eval.arms.spec import ArmSpec
from stucksolver_eval.cases.case import Case
from stucksolver_eval.files import write_text
from stucksolver_eval.guidance import Line, When
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.results.runlog import RunLog
from stucksolver_eval.results.store import Store
from stucksolver_eval.routes import Route
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.runner.work import Task, drive_task
from stucksolver_eval.streets.routes import Where, look_on_map, street_route

SEED = 1
DEADLINE_S, TRIES = 30.0, 20
"""For an answer, and answers in a row that lead nowhere, where nobody says otherwise."""
LADDER = """
[[rung]]
kind = "model"
deadline_s = {deadline_s}
tries = {tries}
cooldown_s = 3.0
"""
"""No rules look before the model: the figure shows what the model itself makes of each scene."""
ANSWERED = (EventKind.DECIDED, EventKind.FAILED)
RUNS, LADDER_FILE = "runs", "ladder.toml"


@dataclass(frozen=True)
class Positions:
    """Where everyone is, in m along the ego's heading at the start, seen from there. `time_s`: since the start."""

    time_s: float
    ego_m: float
    others_m: tuple[float, ...]


@dataclass(frozen=True)
class CaseResult:
    """`decided`: the first decision that a plan came of, else the first of all; None where none was made."""

    case: Case
    decided: Event | None
    events: tuple[Event, ...]
    """Times since the start."""
    progress_m: float
    """Along the route, from the moment of the decision to the end."""
    collisions: int
    moments: tuple[Positions, ...] = ()
    """One for each frame of the replay."""

    @property
    def questions(self) -> int:
        """How many were put to the reasoner."""
        return sum(event.kind in ANSWERED for event in self.events)

    @property
    def unanswered(self) -> int:
        """How many of them it had no usable answer to."""
        return sum(event.kind is EventKind.FAILED for event in self.events)

    @property
    def ending(self) -> str:
        """How it ended, in a few words."""
        kinds = [event.kind for event in self.events]
        touched = f", {self.collisions} collisions" if self.collisions else ", no collision"
        if EventKind.FINISHED in kinds:
            return f"the plan was carried out, {self.progress_m:.0f} m on{touched}"
        if EventKind.ABORTED in kinds:
            last = next(e for e in reversed(self.events) if e.kind is EventKind.ABORTED)
            return f"the plan was given up: {last.text}{touched}"
        if EventKind.FAILED in kinds and self.decided is None:
            return next(e.text for e in self.events if e.kind is EventKind.FAILED)
        return f"it waited, and drove on by itself: {self.progress_m:.0f} m{touched}"


def run_cases(
    cases: tuple[Case, ...],
    reasoner: str,
    out: Path,
    *,
    map_name: str = "grid_town",
    maps: str | None = None,
    clock: str = "lockstep",
    deadline_s: float = DEADLINE_S,
    tries: int = TRIES,
    pictures: bool = True,
    record: bool = False,
    say: Callable[[str], None] = lambda text: None,
) -> list[CaseResult]:
    """Drive each case in a simulator of its own. `deadline_s`, `tries`: as in the ladder's rung `model`.

    `reasoner` is named as on the command line; without `pictures` there is no camera, for reasoners that look at
    none. With `record` the records of interventions and all exchanges with a model are kept. All files go to `out`.

    Raises `CaseError`, `StreetError`, `ServerError`, `LadderError`, `RunError` and `OutputError`.
    """
    # The evaluation profile with one rung.
    rules_of_the_house = profile_text("evaluation").split("[[rung]]")[0]
    ladder = rules_of_the_house + LADDER.format(deadline_s=deadline_s, tries=tries)
    parse_ladder(ladder, "cases")
    write_text(out / LADDER_FILE, ladder)
    arm = ArmSpec(recovery="rules", reasoner=reasoner, clock=clock, ladder=out / LADDER_FILE, camera=pictures)
    places = look_on_map(Where(map_name, maps, SEED), lambda world, town: [one.find(world, town) for one in cases])
    results = []
    for case, place in zip(cases, places, strict=True):
        say(f"{case.title} …")
        route = street_route(case.name.replace("_", "-"), map_name, place.waypoints, case.type, place.parameters)
        results.append(_driven(case, _job(case, route, arm, maps, out if record else None), out / RUNS / case.name))
        say(f"  {results[-1].ending}")
    return results


def _job(case: Case, route: Route, arm: ArmSpec, maps: str | None, records: Path | None) -> RouteJob:
    words = [] if case.words is None else [Line(when=When(time_s=case.words[0]), say=(case.words[1],))]
    return RouteJob(
        route=route,
        seed=SEED,
        arm=arm,
        lines=tuple(words),
        maps=maps,
        replays="all",
        records=records,
        background=False,
        limit_s=case.drive_s,
        events=True,
    )


def _driven(case: Case, job: RouteJob, folder: Path) -> CaseResult:
    """Drive it. Raises `RunError` where that is not possible."""
    outcome = drive_task(Task(job, folder))
    store = Store(folder)
    events = store.events(job.route, job.seed)
    decided = _telling(events, case.shown_from_s)
    return CaseResult(
        case,
        decided,
        events,
        _progress_m(outcome, 0.0 if decided is None else decided.time_s),
        sum(one.kind.startswith("collisions") for one in outcome.infractions),
        _moments(store.run_log(job.route, job.seed)),
    )


def _telling(events: tuple[Event, ...], from_s: float) -> Event | None:
    """The decision to show: the first with a plan that was accepted, else the first."""
    made = [event for event in events if event.kind is EventKind.DECIDED and event.time_s >= from_s]
    accepted = [e for e in made if e.verdict is not None and e.verdict.accepted and e.decision and e.decision.plan]
    return next(iter(accepted or made), None)


def _progress_m(outcome: RouteOutcome, since_s: float) -> float:
    """From the last second before a time to the end."""
    begun_m = max((place_m for time_s, place_m in outcome.track if time_s <= since_s), default=0.0)
    return max(outcome.track[-1][1] - begun_m, 0.0) if outcome.track else 0.0


def _moments(log: RunLog) -> tuple[Positions, ...]:
    others = [k for k, actor in enumerate(log.actors) if actor.role == "scenario"]
    _, x_m, y_m, yaw_deg = log.frames[0].poses[0]
    cos, sin = math.cos(math.radians(yaw_deg)), math.sin(math.radians(yaw_deg))
    ahead_m: dict[int, float] = {}
    found = []
    for frame in log.frames:
        # Who is out of sight for a while is where it was seen last.
        ahead_m |= {k: (x - x_m) * cos + (y - y_m) * sin for k, x, y, _ in frame.poses}
        found.append(Positions(frame.time_s, ahead_m[0], tuple(ahead_m.get(k, 0.0) for k in others)))
    return tuple(found)
