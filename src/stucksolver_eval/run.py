"""Drives one run from start to end and keeps its log."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stucksolver.decision import CONTINUE, Directive
from stucksolver.ladder import find_ladder
from stucksolver.reason import RuleReasoner
from stucksolver.scene import Status
from stucksolver.solver import StuckSolver
from stucksolver.stacks.carla_stack import CarlaStack
from stucksolver.stacks.driver import BehaviorDriver
from stucksolver_eval.jobs import CLIENT_TIMEOUT_S, PROGRESS_EVERY_S, Job
from stucksolver_eval.mapview import map_view
from stucksolver_eval.measure import BLOCKED_S, Measures
from stucksolver_eval.mishaps import Mishaps
from stucksolver_eval.results.outcome import QueryOutcome
from stucksolver_eval.runlog import RunLog, RunResult
from stucksolver_eval.scribe import Scribe
from stucksolver_eval.server import Server, connect, set_synchronous
from stucksolver_eval.sites import Site, choose_site
from stucksolver_eval.situation import Scenario, Situation, build
from stucksolver_eval.traffic import Traffic

DT_S = 0.05
TIME_LIMIT_S = 200.0
SETTLE_TICKS = 10


KINDS = {"one_lane": "one lane each way", "multi_lane": "several lanes"}
LENGTH_M = {Scenario.PARKED_CAR: 170, Scenario.CYCLISTS: 260}
NAMES = {Scenario.PARKED_CAR: "parked car", Scenario.CYCLISTS: "two slow cyclists"}


def run_job(job: Job, server: Server, progress: Callable[[float], None]) -> RunLog:
    """One run on a server, in a fresh world.

    Raises `SiteError`, `SituationError`, `RouteError`, and `RuntimeError` from the client when the server is gone.
    """
    client = connect(server, CLIENT_TIMEOUT_S)
    world = _fresh_world(client, job)
    carla_map = world.get_map()
    site = choose_site(carla_map, job.road, job.seed, LENGTH_M[job.scenario])
    traffic = Traffic(client)
    try:
        return _run(job, world, carla_map, site, traffic, progress)
    finally:
        if job.host is not None:
            traffic.let_go(world)


def _run(
    job: Job, world: Any, carla_map: Any, site: Site, traffic: Traffic, progress: Callable[[float], None]
) -> RunLog:
    oncoming = job.oncoming if site.kind == "one_lane" else 0
    situation = build(world, site, job.scenario, oncoming, traffic, job.seed)
    for _ in range(SETTLE_TICKS):
        world.tick()
    driver = BehaviorDriver(situation.ego, job.profile, carla_map=carla_map)
    driver.set_destination(site.destination.transform.location)
    stack = CarlaStack(situation.ego, driver, carla_map)
    mishaps = Mishaps(world, situation.ego)
    scribe = Scribe(world, situation.ego, situation.role_of)
    solver = _solver(job, stack, scribe) if job.with_solver else None
    try:
        loop = _Loop(job, world, situation, stack, solver, scribe, mishaps)
        status = loop.go(progress)
        title = f"{NAMES[job.scenario]}, {KINDS[site.kind]}" + (f", {oncoming} oncoming" if oncoming else "")
        return _log(job, title, site, carla_map, loop, status)
    finally:
        if solver is not None:
            solver.close()
        mishaps.close()


def _fresh_world(client: Any, job: Job) -> Any:
    """A world without anyone in it, in synchronous mode. A server of our own has just made one."""
    world = client.get_world() if job.host is None else client.load_world(job.map_name)
    set_synchronous(world, DT_S)
    return world


def _solver(job: Job, stack: CarlaStack, scribe: Scribe) -> StuckSolver:
    usual = find_ladder(None)
    # As in the evaluation profile: a solid line may be crossed past a stationary obstruction without asking.
    approval = usual.approval.model_copy(update={"solid_line": "autonomous"})
    ladder = usual.model_copy(update={"approval": approval})
    return StuckSolver(stack.scene, ladder=ladder, reasoner=RuleReasoner(), clock=job.clock, on_event=scribe.hear)


class _Loop:
    """The tick loop: status in, directive out, control applied, world ticked, everything noted."""

    def __init__(
        self,
        job: Job,
        world: Any,
        situation: Situation,
        stack: CarlaStack,
        solver: StuckSolver | None,
        scribe: Scribe,
        mishaps: Mishaps,
    ) -> None:
        self._world, self._ego = world, situation.ego
        self._stack, self._solver = stack, solver
        self.scribe, self.mishaps = scribe, mishaps
        first = stack.status()
        self.start_s = first.time_s
        self.measures = Measures(length_m=stack.route_length_m, start_m=first.progress_m)
        self._words = sorted(job.guidance)
        self.elapsed_s = 0.0
        self._next_progress_s = 0.0

    def go(self, progress: Callable[[float], None]) -> str:
        """Until the destination, a block of 60 s, or the time limit; returns which."""
        while True:
            status = self._stack.status()
            self.elapsed_s = status.time_s - self.start_s
            ending = self._note(status)
            if ending is not None:
                return ending
            directive: Directive = CONTINUE
            if self._solver is not None:
                while self._words and self.elapsed_s >= self._words[0][0]:
                    self._solver.guide(self._words.pop(0)[1])
                directive = self._solver.step(status, self._stack.surroundings)
                self.scribe.directive(status.time_s - self.start_s, directive)
            self._ego.apply_control(self._stack.perform(directive))
            self._world.tick()
            if self.elapsed_s >= self._next_progress_s:
                self._next_progress_s += PROGRESS_EVERY_S
                progress(self.elapsed_s)

    def _note(self, status: Status) -> str | None:
        self.measures.update(status)
        for told in self.mishaps.update(self.elapsed_s):
            self.scribe.event(told.time_s, "infraction", told.text)
        self.scribe.frame(self.elapsed_s, status.speed_mps)
        if status.at_destination:
            return "completed"
        if self.measures.standing_run_s > BLOCKED_S:
            return "blocked"
        return "timeout" if self.elapsed_s > TIME_LIMIT_S else None


def _log(job: Job, title: str, site: Site, carla_map: Any, loop: _Loop, status: str) -> RunLog:
    m, scribe = loop.measures, loop.scribe
    for told in loop.mishaps.finish():
        scribe.event(told.time_s, "infraction", told.text)
    scribe.event(loop.elapsed_s, "run", status)
    route = [(w.transform.location.x, -w.transform.location.y) for w in site.waypoints]
    result = RunResult(
        status=status,
        route_completion_pct=m.completion_pct,
        infractions=loop.mishaps.counts,
        stopped_s=round(m.standing_s, 2),
        time_to_recover_s=round(m.recovery_times_s[0], 2) if m.recovery_times_s else None,
        immobilizations=m.immobilizations,
        decisions=len(scribe.decisions),
        plans_accepted=sum(d.outcome is QueryOutcome.ACCEPTED for d in scribe.decisions),
        duration_s=round(loop.elapsed_s, 2),
        distance_m=round(m.completion_pct / 100 * m.length_m, 1),
    )
    return RunLog(
        scenario=title,
        arm=job.arm,
        seed=job.seed,
        driver=f"behavior:{job.profile}",
        reasoner="rules" if job.with_solver else "none",
        clock=job.clock,
        perception=CarlaStack.perception,
        map=map_view(carla_map, route),
        route=tuple((round(x, 2), round(y, 2)) for x, y in route[::2]),
        actors=tuple(scribe.actors),
        frames=tuple(scribe.frames),
        stuck=tuple((round(a - loop.start_s, 2), round(b - loop.start_s, 2)) for a, b in m.stuck),
        decisions=tuple(scribe.decisions),
        events=tuple(sorted(scribe.events, key=lambda e: e.time_s)),
        result=result,
    )
