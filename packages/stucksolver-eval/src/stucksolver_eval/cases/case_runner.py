"""Drives the cases: scene, reasoner, guard and execution."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from stucksolver.atomic_files import write_text
from stucksolver.ladder import parse_ladder, profile_text
from stucksolver.solver import Event, EventKind
from stucksolver_eval.cases.case import Case
from stucksolver_eval.guidance import ScriptLine, ScriptTrigger
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.results.run_log import RunLog
from stucksolver_eval.results.store import ResultStore
from stucksolver_eval.routes import Route
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.runner.route_process import RouteTask, drive_task
from stucksolver_eval.streets.routes import SimulatorTarget, street_route, with_map
from stucksolver_eval.systems.spec import SystemSpec

SEED = 1
"""Seed of the traffic. Ours."""
DEADLINE_S, TRIES = 30.0, 20
"""Defaults: time limit for an answer (s), and failed attempts in a row before the run ends. Ours."""
LADDER = """
[[rung]]
kind = "model"
deadline_s = {deadline_s}
tries = {tries}
cooldown_s = 3.0
"""
"""The ladder. The model has the first rung, because the figure shows how the model itself judges each scene."""
ANSWERED = (EventKind.DECIDED, EventKind.FAILED)
RUNS, LADDER_FILE = "runs", "ladder.toml"


@dataclass(frozen=True)
class Positions:
    """Positions of ego and others along the ego's initial heading, from its initial position (m), at a time (s)."""

    time_s: float
    ego_m: float
    others_m: tuple[float, ...]


@dataclass(frozen=True)
class CaseResult:
    """The result of a case. `decided` is the first decision with an accepted plan, else the first decision, or None."""

    case: Case
    decided: Event | None
    events: tuple[Event, ...]
    """The solver's events, with times since the start (s)."""
    progress_m: float
    """Progress along the route from the decision to the end (m)."""
    collisions: int
    moments: tuple[Positions, ...] = ()
    """Positions in each frame of the replay."""

    @property
    def questions(self) -> int:
        """Number of queries to the reasoner."""
        return sum(event.kind in ANSWERED for event in self.events)

    @property
    def unanswered(self) -> int:
        """Number of queries without a usable answer."""
        return sum(event.kind is EventKind.FAILED for event in self.events)

    @property
    def ending(self) -> str:
        """The outcome in a few words."""
        kinds = [event.kind for event in self.events]
        touched = f", {self.collisions} collisions" if self.collisions else ", no collision"
        if EventKind.FINISHED in kinds:
            return f"the plan was completed, {self.progress_m:.0f} m of progress{touched}"
        if EventKind.ABORTED in kinds:
            last = next(e for e in reversed(self.events) if e.kind is EventKind.ABORTED)
            return f"the plan was aborted: {last.text}{touched}"
        if EventKind.FAILED in kinds and self.decided is None:
            return next(e.text for e in self.events if e.kind is EventKind.FAILED)
        return f"it waited, then drove on by itself: {self.progress_m:.0f} m of progress{touched}"


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
    """Drive each case in a separate simulator, and return the results in order.

    Args:
        cases: The cases.
        reasoner: Name of the reasoner, as on the command line.
        out: Folder for all files.
        map_name: Name of a town, or an OpenDRIVE file.
        maps: Folders to search for towns, separated by ":".
        clock: Clock of the solver, as on the command line.
        deadline_s: Time limit for an answer (s); see the ladder's rung `model`.
        tries: Failed attempts in a row before the run ends; see the ladder's rung `model`.
        pictures: Carry a camera.
        record: Write records of interventions and all exchanges with a model.
        say: Called with progress messages.

    Raises:
        CaseError: The map has no position for a case.
        StreetError: The map has no suitable street.
        ServerError: The simulator did not start or ended.
        LadderError: The deadline or the number of tries is not allowed.
        RunError: A drive failed.
        OutputError: A file cannot be written.
    """
    # The evaluation profile with a single rung.
    head = profile_text("evaluation").split("[[rung]]")[0]
    ladder = head + LADDER.format(deadline_s=deadline_s, tries=tries)
    parse_ladder(ladder, "cases")
    write_text(out / LADDER_FILE, ladder)
    arm = SystemSpec(recovery="search", reasoner=reasoner, clock=clock, ladder=out / LADDER_FILE, camera=pictures)
    places = with_map(
        SimulatorTarget(map_name, maps, SEED), lambda world, town: [case.find(world, town) for case in cases]
    )
    results = []
    for case, place in zip(cases, places, strict=True):
        say(f"{case.title} …")
        route = street_route(case.name.replace("_", "-"), map_name, place.waypoints, case.type, place.parameters)
        results.append(_driven(case, _job(case, route, arm, maps, out if record else None), out / RUNS / case.name))
        say(f"  {results[-1].ending}")
    return results


def _job(case: Case, route: Route, arm: SystemSpec, maps: str | None, records: Path | None) -> RouteJob:
    words = [] if case.words is None else [ScriptLine(when=ScriptTrigger(time_s=case.words[0]), say=(case.words[1],))]
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
    """Drive a case and return its result. Raises `RunError`."""
    outcome = drive_task(RouteTask(job, folder))
    store = ResultStore(folder)
    events = store.events(job.route, job.seed)
    decided = _telling(events, case.shown_from_s)
    return CaseResult(
        case,
        decided,
        events,
        _progress_m(outcome, 0.0 if decided is None else decided.time_s),
        sum(infraction.kind.startswith("collisions") for infraction in outcome.infractions),
        _moments(store.run_log(job.route, job.seed)),
    )


def _telling(events: tuple[Event, ...], from_s: float) -> Event | None:
    """Return the decision for the figure: the first with an accepted plan, else the first, or None."""
    made = [event for event in events if event.kind is EventKind.DECIDED and event.time_s >= from_s]
    accepted = [e for e in made if e.verdict is not None and e.verdict.accepted and e.decision and e.decision.plan]
    return next(iter(accepted or made), None)


def _progress_m(outcome: RouteOutcome, since_s: float) -> float:
    """Return the progress from the last track point before `since_s` to the end (m)."""
    begun_m = max((place_m for time_s, place_m in outcome.track if time_s <= since_s), default=0.0)
    return max(outcome.track[-1][1] - begun_m, 0.0) if outcome.track else 0.0


def _moments(log: RunLog) -> tuple[Positions, ...]:
    others = [k for k, actor in enumerate(log.actors) if actor.role == "scenario"]
    _, x_m, y_m, yaw_deg = log.frames[0].poses[0]
    cos, sin = math.cos(math.radians(yaw_deg)), math.sin(math.radians(yaw_deg))
    ahead_m: dict[int, float] = {}
    found = []
    for frame in log.frames:
        # An actor that is missing in a frame keeps its last position.
        ahead_m |= {k: (x - x_m) * cos + (y - y_m) * sin for k, x, y, _ in frame.poses}
        found.append(Positions(frame.time_s, ahead_m[0], tuple(ahead_m.get(k, 0.0) for k in others)))
    return tuple(found)
