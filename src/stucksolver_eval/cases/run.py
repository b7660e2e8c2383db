"""Acts the cases out: from the scene through the reasoner and the guard to the drive."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from stucksolver.ladder import Ladder, parse_ladder, profile_text
from stucksolver.reason import Reasoner
from stucksolver.scene import Scene
from stucksolver.solver import Event, EventKind, StuckSolver
from stucksolver.stacks.carla_stack import CarlaStack
from stucksolver.stacks.carla_stack.camera import FrontCamera
from stucksolver.stacks.driver import BehaviorDriver
from stucksolver_eval.cases.case import Case, CaseError, Staged
from stucksolver_eval.mishaps import Mishaps
from stucksolver_eval.server import Server, ServerError, carlette_server, connect, set_synchronous
from stucksolver_eval.situation import SituationError

DT_S = 0.05
SETTLE_TICKS = 10
CLIENT_TIMEOUT_S = 60.0
PICTURE_LIMIT_S = 180.0
ENOUGH_S = 25.0
"""After a first answer without a plan, it is watched for this long."""
MOMENT_S = 0.5
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


@dataclass(frozen=True)
class Moment:
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
    progress_m: float
    """Along the route, from the moment of the decision to the end."""
    collisions: int
    moments: tuple[Moment, ...] = ()
    """One every `MOMENT_S`."""

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
    reasoner: Callable[[], Reasoner],
    *,
    map_name: str = "grid_town",
    maps: str | None = None,
    clock: str = "lockstep",
    deadline_s: float = DEADLINE_S,
    tries: int = TRIES,
    pictures: bool = True,
    say: Callable[[str], None] = lambda text: None,
) -> list[CaseResult]:
    """Each case in a simulator of its own. `deadline_s`, `tries`: as in the ladder's rung `model`.

    Without `pictures` there is no camera, for reasoners that look at none.

    Raises `CaseError`, `SituationError`, `SiteError`, `ServerError`.
    """
    results = []
    for case in cases:
        say(f"{case.title} …")
        with carlette_server(map_name, maps) as server:
            results.append(_answered(case, reasoner(), server, clock, _ladder(deadline_s, tries), pictures))
        say(f"  {results[-1].ending}")
    return results


@dataclass(frozen=True)
class _Scenery:
    """A case in a world that ticks when told to."""

    world: Any
    carla_map: Any
    staged: Staged
    mishaps: Mishaps
    camera: FrontCamera | None


def _answered(case: Case, reasoner: Reasoner, server: Server, clock: str, ladder: Ladder, pictures: bool) -> CaseResult:
    """The client library tells of a simulator that is gone by a bare `RuntimeError`."""
    try:
        return _run(case, reasoner, server, clock, ladder, pictures)
    except SituationError:
        raise
    except RuntimeError as error:
        server.check()
        raise ServerError(f"the simulator does not answer: {error}; run again") from error


def _run(case: Case, reasoner: Reasoner, server: Server, clock: str, ladder: Ladder, pictures: bool) -> CaseResult:
    world = connect(server, CLIENT_TIMEOUT_S).get_world()
    set_synchronous(world, DT_S)
    carla_map = world.get_map()
    staged = case.stage(world, carla_map)
    camera = FrontCamera(staged.ego) if pictures else None
    mishaps = Mishaps(world, staged.ego)
    try:
        for _ in range(SETTLE_TICKS):
            world.tick()
        if camera is not None:
            _await_picture(world, camera)
        return _drive(case, reasoner, _Scenery(world, carla_map, staged, mishaps, camera), clock, ladder)
    finally:
        if camera is not None:
            camera.close()
        mishaps.close()


def _await_picture(world: Any, camera: FrontCamera) -> None:
    """A simulator may build its scenery before the first picture; a case without one would show nothing."""
    deadline_s = time.monotonic() + PICTURE_LIMIT_S
    while camera.image() is None:
        if time.monotonic() > deadline_s:
            raise CaseError(f"the front camera gave no picture within {PICTURE_LIMIT_S:.0f} s; run again")
        time.sleep(DT_S)
        world.tick()


def _drive(case: Case, reasoner: Reasoner, scenery: _Scenery, clock: str, ladder: Ladder) -> CaseResult:
    staged, mishaps, camera = scenery.staged, scenery.mishaps, scenery.camera
    driver = BehaviorDriver(staged.ego, "normal", carla_map=scenery.carla_map)
    driver.set_destination(staged.destination)
    stack = CarlaStack(staged.ego, driver, scenery.carla_map)
    start = staged.ego.get_transform()
    events: list[Event] = []
    moments: list[Moment] = []
    decided: Event | None = None
    decided_s = decided_m = progress_m = 0.0
    words = case.words

    def scene() -> Scene:
        seen = stack.scene()
        return seen if camera is None else camera.seen_by(seen)

    with StuckSolver(scene, models={"model": reasoner}, ladder=ladder, clock=clock, on_event=events.append) as solver:
        start_s = stack.status().time_s
        while True:
            status = stack.status()
            now, progress_m = status.time_s - start_s, status.progress_m
            staged.every_tick(now)
            mishaps.update(now)
            if not moments or now - moments[-1].time_s >= MOMENT_S - DT_S / 2:
                others = tuple(_along(start, one) for one in staged.others)
                moments.append(Moment(now, _along(start, staged.ego), others))
            if words is not None and now >= words[0]:
                solver.guide(words[1])
                words = None
            staged.ego.apply_control(stack.perform(solver.step(status, stack.surroundings)))
            found = _telling(events, start_s + case.shown_from_s)
            if found is not None and (decided is None or decided is not found):
                decided, decided_s, decided_m = found, now, progress_m
            over = decided is not None and now - decided_s > ENOUGH_S and not case.to_the_end
            if over or status.at_destination or now > case.drive_s:
                break
            scenery.world.tick()
    mishaps.finish()
    return CaseResult(case, decided, tuple(events), progress_m - decided_m, mishaps.collisions, tuple(moments))


def _along(start: Any, actor: Any) -> float:
    """How far `actor` is ahead of the transform `start`, in m."""
    return float((actor.get_location() - start.location).dot(start.get_forward_vector()))


def _ladder(deadline_s: float, tries: int) -> Ladder:
    """The evaluation profile with one rung. Raises `LadderError` for what is out of its bounds."""
    rules_of_the_house = profile_text("evaluation").split("[[rung]]")[0]
    return parse_ladder(rules_of_the_house + LADDER.format(deadline_s=deadline_s, tries=tries), "cases")


def _telling(events: list[Event], from_s: float) -> Event | None:
    """The decision to show: the first with a plan that was accepted, else the first."""
    made = [event for event in events if event.kind is EventKind.DECIDED and event.time_s >= from_s]
    accepted = [e for e in made if e.verdict is not None and e.verdict.accepted and e.decision and e.decision.plan]
    return next(iter(accepted or made), None)
