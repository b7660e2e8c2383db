"""Drives one run from start to end and keeps its log."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from stucksolver.decision import CONTINUE, Directive
from stucksolver.evaluate.mapview import map_view
from stucksolver.evaluate.measure import BLOCKED_S, CollisionWatch, Measures
from stucksolver.evaluate.runlog import RunLog, RunResult
from stucksolver.evaluate.scribe import Scribe
from stucksolver.evaluate.sites import Site
from stucksolver.evaluate.situation import Scenario, Situation, build
from stucksolver.evaluate.traffic import Traffic
from stucksolver.guard import Guard, GuardPolicy
from stucksolver.reason import RuleReasoner
from stucksolver.scene import Status
from stucksolver.solver import StuckSolver
from stucksolver.stacks.carla_stack import CarlaStack
from stucksolver.stacks.driver import BehaviorDriver

DT_S = 0.05
TIME_LIMIT_S = 200.0
SETTLE_TICKS = 10


@dataclass(frozen=True)
class RunSpec:
    """What to run. `guidance`: (seconds after the start, the passenger's words)."""

    scenario: Scenario
    site: Site
    title: str
    arm: str
    with_solver: bool
    guidance: tuple[tuple[float, str], ...] = ()
    oncoming: int = 0
    seed: int = 0
    profile: str = "normal"
    clock: str = "lockstep"


def run(
    spec: RunSpec, client: Any, traffic: Traffic, on_tick: Callable[[float], None] = lambda elapsed_s: None
) -> RunLog:
    """One run in a fresh world. Raises `SituationError`, `RouteError`, and `RuntimeError` from the client."""
    world = _fresh_world(client)
    situation = build(world, spec.site, spec.scenario, spec.oncoming, traffic, spec.seed)
    for _ in range(SETTLE_TICKS):
        world.tick()
    carla_map = world.get_map()
    driver = BehaviorDriver(situation.ego, spec.profile, carla_map=carla_map)
    driver.set_destination(spec.site.destination.transform.location)
    stack = CarlaStack(situation.ego, driver, carla_map)
    collisions = CollisionWatch(world, situation.ego)
    scribe = Scribe(world, situation)
    solver = _solver(spec, stack, scribe) if spec.with_solver else None
    try:
        loop = _Loop(spec, world, situation, stack, solver, scribe, collisions)
        status = loop.go(on_tick)
        return _log(spec, carla_map, driver, loop, status)
    finally:
        if solver is not None:
            solver.close()
        collisions.close()


def _fresh_world(client: Any) -> Any:
    """A world without anyone in it, in synchronous mode."""
    world = client.reload_world()
    settings = world.get_settings()
    settings.synchronous_mode, settings.fixed_delta_seconds = True, DT_S
    world.apply_settings(settings)
    return world


def _solver(spec: RunSpec, stack: CarlaStack, scribe: Scribe) -> StuckSolver:
    # The evaluation profile: a solid line may be crossed past a stationary obstruction without asking.
    guard = Guard(GuardPolicy(solid_line="autonomous"))
    return StuckSolver(stack.scene, reasoner=RuleReasoner(), guard=guard, clock=spec.clock, on_event=scribe.hear)


class _Loop:
    """The tick loop: status in, directive out, control applied, world ticked, everything noted."""

    def __init__(
        self,
        spec: RunSpec,
        world: Any,
        situation: Situation,
        stack: CarlaStack,
        solver: StuckSolver | None,
        scribe: Scribe,
        collisions: CollisionWatch,
    ) -> None:
        self._world, self._ego = world, situation.ego
        self._stack, self._solver = stack, solver
        self.scribe, self.collisions = scribe, collisions
        first = stack.status()
        self.start_s = first.time_s
        self.measures = Measures(length_m=stack.route_length_m, start_m=first.progress_m)
        self._words = sorted(spec.guidance)
        self.elapsed_s = 0.0

    def go(self, on_tick: Callable[[float], None]) -> str:
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
            on_tick(self.elapsed_s)

    def _note(self, status: Status) -> str | None:
        self.measures.update(status)
        for text in self.collisions.news:
            self.scribe.event(self.elapsed_s, "infraction", text)
        self.collisions.news.clear()
        ego, objects = self.scribe.frame(self.elapsed_s, status.speed_mps)
        if ego is not None:
            for text in self.measures.look(ego, objects):
                self.scribe.event(self.elapsed_s, "infraction", text)
        if status.at_destination:
            return "completed"
        if self.measures.standing_run_s > BLOCKED_S:
            return "blocked"
        return "timeout" if self.elapsed_s > TIME_LIMIT_S else None


def _log(spec: RunSpec, carla_map: Any, driver: BehaviorDriver, loop: _Loop, status: str) -> RunLog:
    m, scribe = loop.measures, loop.scribe
    scribe.event(loop.elapsed_s, "run", status)
    route = [(w.transform.location.x, -w.transform.location.y) for w in spec.site.waypoints]
    infractions = dict(loop.collisions.counts)
    if m.near_misses:
        infractions["near_miss"] = m.near_misses
    result = RunResult(
        status=status,
        route_completion_pct=m.completion_pct,
        infractions=infractions,
        stopped_s=round(m.standing_s, 2),
        time_to_recover_s=round(m.recovery_times_s[0], 2) if m.recovery_times_s else None,
        immobilizations=m.immobilizations,
        decisions=len(scribe.decisions),
        plans_accepted=sum(d.verdict == "accepted" for d in scribe.decisions),
        duration_s=round(loop.elapsed_s, 2),
        distance_m=round(m.completion_pct / 100 * m.length_m, 1),
    )
    return RunLog(
        scenario=spec.title,
        arm=spec.arm,
        seed=spec.seed,
        driver=f"behavior:{spec.profile}",
        reasoner="rules" if spec.with_solver else "none",
        clock=spec.clock,
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
