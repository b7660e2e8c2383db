"""The state machine on random drives: it is pure, takes only the ways of its table, and always finds out again."""

from __future__ import annotations

import contextlib
import itertools
import math
import os
import random
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest

from given_up import GivesUp, askew
from grids import WHOLE
from stucksolver.guard import Guard
from stucksolver.interpreter import ScriptedInterpreter
from stucksolver.plan import CONTINUE, Execute, SafeStop
from stucksolver.reasoners import ReasonerError, SearchReasoner
from stucksolver.reasoners.faulty import make_faulty
from stucksolver.record import Recorder, replay
from stucksolver.record.serialization import step_output_data
from stucksolver.scene import DirectedSide, GuidanceIntent, Interpretation, LineKind, ObjectKind, Zone, ZoneKind
from stucksolver.solver import ExecutionTick, PlanReview, QuestionError, QuestionKind, StuckSolver, TransitionStep
from stucksolver.solver.state_machine.execution_steps import STAND
from stucksolver.solver.state_machine.inputs import SolverSetup
from stucksolver.solver.state_machine.state import (
    AwaitingApproval,
    AwaitingGap,
    Driving,
    Executing,
    Holding,
    MinimalRisk,
    Monitoring,
    StateName,
)
from stucksolver.solver.state_machine.table import ACTIVITIES, POSTURES, page
from stucksolver.solver.state_machine.transition import transition
from worlds import LANE_M, World, ladder, red_light, straight_road, stubborn, thing

pytestmark = pytest.mark.integration
ROADS = (
    straight_road(),
    straight_road(oncoming=LineKind.SOLID),
    straight_road(left=LineKind.BROKEN, oncoming=None),
)


def read_as(intent, **more):
    return Interpretation(intent=intent, likely=intent, confidence=0.95, reader="scripted", **more)


READINGS = {
    "go round it": read_as(GuidanceIntent.OVERTAKE, side=DirectedSide.LEFT),
    "wait": read_as(GuidanceIntent.WAIT),
    "do not go": read_as(GuidanceIntent.GO, negated=True),
    "drive on": read_as(GuidanceIntent.GO),
    "yes": read_as(GuidanceIntent.YES),
    "no": read_as(GuidanceIntent.NO),
    "nice day": read_as(GuidanceIntent.NONE),
    "back up": read_as(GuidanceIntent.BACK_UP),
    "over the pavement": read_as(GuidanceIntent.UNLAWFUL),
    "cancel": read_as(GuidanceIntent.CANCEL),
}
WORDS = (*READINGS, "hm")
QUICK = {"reasoner": {"tries": 2, "cooldown_s": 0.5}, "passenger": {"within_s": 3.0}, "model": None}
LADDERS = {
    "default": ladder,
    "quick": lambda: ladder(rungs=QUICK),
    "asks": lambda: ladder(solid_line="passenger", rungs=QUICK),
    "stubborn": lambda: stubborn(),
    "people first": lambda: people_first(),
    "help soon": lambda: ladder(rungs={"reasoner": {"tries": 1, "cooldown_s": 0.2}, "model": None, "passenger": None}),
}
MORE_DRIVES = int(os.environ.get("MACHINE_DRIVES", "8"))
SEEDS = tuple(dict.fromkeys((12, 14, 19, 33, 41, 214, 1004, *range(1000, 1000 + MORE_DRIVES))))
"""The first seven take every way of the table that chance has been seen to take."""


def people_first():
    """The passenger is asked before the rules are."""
    usual = ladder(rungs=QUICK)
    by_kind = {rung.kind: rung for rung in usual.rungs}
    return usual.model_copy(update={"rungs": tuple(by_kind[kind] for kind in ("passenger", "reasoner", "remote"))})


@dataclass
class Run:
    """Every step of a drive; hands them on to a recorder."""

    seed: int | str
    recorder: Recorder | None
    steps: list[TransitionStep] = field(default_factory=list)
    setup: SolverSetup | None = None
    observes: bool = False

    @property
    def files(self):
        return self.recorder.files

    def begin(self, facts):
        guard = Guard(facts.policy)
        self.observes = facts.observe_only
        self.setup = SolverSetup(guard, facts.ladder, dict(facts.reasoners), facts.ask_back, facts.observe_only)
        if self.recorder:
            self.recorder.begin(facts)

    def fault(self, event):
        if self.recorder:
            self.recorder.fault(event)

    def step(self, step):
        self.steps.append(step)
        if self.recorder:
            self.recorder.step(step)


class Dice:
    """A reasoner that is right, wrong, late or broken, as the dice fall."""

    name = "dice"

    def __init__(self, rng):
        self.rng = rng
        self.others = [SearchReasoner(), SearchReasoner(), make_faulty("random", seed=rng.randrange(99))]

    def decide(self, request):
        if self.rng.random() < 0.1:
            raise ReasonerError("the dice said no")
        return self.rng.choice(self.others).decide(request)


def scenery(rng):
    """A road, somebody in the way, somebody who moves, at random."""
    road = rng.choice(ROADS)
    objects = [thing("lead", 75.0, rng.uniform(-0.4, 0.4))]
    if rng.random() < 0.5:
        objects += [thing(f"car{k}", rng.uniform(90, 250), LANE_M, speed=-rng.uniform(5, 10)) for k in range(3)]
    if rng.random() < 0.3:
        objects.append(thing("walker", 85.0, -3.0, kind=ObjectKind.PEDESTRIAN, sideways=rng.choice([0.0, 1.0])))
    controls = (red_light(rng.uniform(5, 30)),) if rng.random() < 0.15 else ()
    return World(road, objects, controls, x=rng.choice([50.0, 66.0, 69.0]))


def random_drive(seed, recorder=None, seconds=24.0, calm_s=70.0):
    """Everything that a stack, a passenger, an operator and time may do, in any order; then a free street."""
    rng = random.Random(seed)
    world, name = scenery(rng), rng.choice(list(LADDERS))
    run = Run(seed, recorder)
    options = {
        "ladder": LADDERS[name](),
        "clock": rng.choice(["lockstep", "lockstep", "latency:0.4"]),
        "reasoner": rng.choice([None, Dice(rng)]),
        "observe_only": rng.random() < 0.05,
        "reader": ScriptedInterpreter(READINGS),
        "record": run,
    }
    with recorder or contextlib.nullcontext(), StuckSolver(world.scene, **options) as solver:
        for _ in range(round(seconds / world.dt)):
            meddle(rng, world, solver)
            world.drive(solver.step(spoilt(rng, world), spoilt_view(rng, world)))
        world.objects, world.controls = [], ()
        for _ in range(round(calm_s / world.dt)):
            pending = solver.pending_question
            if pending is not None and pending.kind is not QuestionKind.ADVICE:
                solver.approve(by="operator")
            world.drive(solver.step(world.status(), world.surroundings))
            if not solver.state.engaged and world.frame % 20 == 0:
                break
    return run


def meddle(rng, world, solver):
    """Words, answers, things that come and go."""
    if rng.random() < 0.01:
        solver.guide(rng.choice(WORDS))
    if rng.random() < 0.05 and solver.pending_question is not None:
        with contextlib.suppress(QuestionError):  # it is for somebody else, or wants words
            rng.choice([solver.approve, solver.deny])(by=rng.choice(["passenger", "operator"]))
    if rng.random() < 0.003:
        world.objects = world.objects[1:]
    if rng.random() < 0.003:
        world.objects = [
            *world.objects,
            thing(f"new{world.frame}", world.x + rng.uniform(8, 40), rng.choice([0, LANE_M])),
        ]


def spoilt(rng, world):
    status = world.status()
    if rng.random() < 0.003:
        return status.model_copy(update={"speed_mps": math.nan})
    if rng.random() < 0.002:
        world.time_s += rng.choice([-5.0, 30.0])
    return world.status()


def spoilt_view(rng, world):
    """A look around that may bring nothing at all."""
    return (lambda: None) if rng.random() < 0.01 else world.surroundings


def staged(name):
    """What chance hardly brings about. The operator says yes after 20 s, and all is gone after 30 s."""
    world, options, meddles = STAGED[name]()
    run = Run(name, None)
    with StuckSolver(world.scene, clock="lockstep", record=run, **options) as solver:
        for _ in range(round(75.0 / world.dt)):
            meddles(world, solver)
            if world.time_s > 30.0:
                world.objects, world.cruise_mps = [], 8.0
            pending = solver.pending_question
            if world.time_s > 20.0 and pending is not None and pending.kind is QuestionKind.ASSISTANCE:
                solver.approve(by="operator")
            world.drive(solver.step(world.status(), world.surroundings))
    return run


def held_then_helped():
    """Given up askew, held there, help is called, and the vehicle is held again after the operator's yes."""
    world = World(ROADS[2], [thing("lead", 60.0)])
    return world, {"guard": GivesUp(askew), "ladder": LADDERS["help soon"]()}, lambda world, solver: None


def approved_into(*comes):
    """Over a solid line with a passenger's yes; with the yes there comes what was not there before."""

    def make():
        def agree(world, solver):
            pending = solver.pending_question
            if pending is not None and pending.kind is QuestionKind.APPROVAL:
                if len(world.objects) == 1:
                    world.objects = [*world.objects, *(come(world) for come in comes)]
                solver.approve()

        slow = ladder(solid_line="passenger", rungs={"model": None, "reasoner": {"tries": 9, "repair_rounds": 2}})
        world = World(ROADS[1], [thing("lead", 75.0)], x=60.0, cruise_mps=0.0)
        return world, {"ladder": slow}, agree

    return make


def other_words_at_a_gap():
    """While the plan waits for a gap in the traffic, the passenger asks for it in other words."""
    world, options, agree = STAGED["a yes, and a car comes"]()

    def speak(world, solver):
        agree(world, solver)
        if isinstance(solver.state.activity, AwaitingGap) and world.frame % 5 == 0:
            solver.guide(WORDS[0])

    return world, options | {"reader": ScriptedInterpreter(READINGS)}, speak


def a_gap_comes():
    """Cars pass beside; the plan is held until they have passed, and begins."""
    cars = [thing(f"car{k}", 50.0 - 14.0 * k, LANE_M, speed=8.0) for k in range(-2, 4)]
    return (
        World(ROADS[2], [thing("lead", 65.0), *cars], cruise_mps=0.0),
        {"ladder": stubborn()},
        lambda world, solver: None,
    )


class Silent:
    """Never answers."""

    name = "silent"

    def decide(self, request):
        raise ReasonerError("no answer")


def stopped_then_free():
    """Nobody has an idea, and nobody is there to be asked: the stop ends with what stands in the way."""
    world = World(ROADS[1], [thing("wall", 70.0, width=6.0)], x=60.0)
    return world, {"ladder": LADDERS["help soon"](), "reasoner": Silent()}, lambda world, solver: None


def helped_off_a_crosswalk():
    """Help is called where nobody may stand: the vehicle first leaves the place."""
    road = straight_road(oncoming=LineKind.SOLID, zones=(Zone(kind=ZoneKind.CROSSWALK, start_m=47.0, end_m=53.0),))
    world = World(road, [thing("wall", 66.0, 1.0, width=6.0, length=1.0)], x=50.0, cruise_mps=0.0)
    return world, {"ladder": LADDERS["help soon"](), "reasoner": Silent()}, lambda world, solver: None


STAGED = {
    "stopped, then free": stopped_then_free,
    "helped off a crosswalk": helped_off_a_crosswalk,
    "a gap comes": a_gap_comes,
    "held, then helped": held_then_helped,
    "a yes": approved_into(),
    "a yes, and a car comes": approved_into(lambda w: thing("car", w.x + 90.0, LANE_M, speed=-8.0)),
    "other words at a gap": other_words_at_a_gap,
    "a yes, and the other lane is shut": approved_into(lambda w: thing("shut", w.x + 22.0, LANE_M)),
}


@pytest.fixture(scope="module")
def drives():
    return [*map(random_drive, SEEDS), *map(staged, STAGED)]


def test_no_way_is_taken_that_the_table_does_not_name(drives):
    for run in drives:
        for step in run.steps:
            (activity, posture), (then, there) = step.before.names, step.after.names
            if step.after.activity != step.before.activity and not isinstance(step.after.activity, Executing):
                assert (activity, then) in ACTIVITIES, (run.seed, activity, then)
            assert then is not StateName.EXECUTING or activity is then or (activity, then) in ACTIVITIES
            assert posture is there or (posture, there) in POSTURES, (run.seed, posture, there)


def test_each_step_goes_on_from_the_state_before(drives):
    for run in drives:
        for step, other in itertools.pairwise(run.steps):
            assert other.before is step.after


def test_a_step_is_pure(drives):
    """Taken again with the same inputs it gives the same, and leaves the state that it began from as it was."""
    for run in drives[: len(SEEDS) : 2]:
        for step in run.steps[:: max(len(run.steps) // 40, 1)]:
            shown = repr(step.before)
            state, directive, told = transition(step.before, step.inputs, run.setup)
            assert repr(step.before) == shown
            assert state.names == step.after.names
            assert directive == step.directive
            again = replace(step, directive=directive, outputs=told)
            assert [step_output_data(item, again) for item in told] == [
                step_output_data(item, step) for item in step.outputs
            ]


def test_directive_that_moves_vehicle_has_verdict_of_same_tick(drives):
    """Each directive that moves the vehicle belongs to an accepted plan that was ticked in that step."""
    moved = 0
    for run in drives:
        accepted = None
        for step in run.steps:
            for item in step.outputs:
                if isinstance(item, PlanReview) and item.verdict.accepted:
                    accepted = item.plan
            directive = step.directive
            held = isinstance(step.after.posture, Holding)  # a hold brakes, and needs no plan for that
            if not isinstance(directive, Execute) or directive is STAND or (held and not directive.path):
                continue
            ticks = [item for item in step.outputs if isinstance(item, ExecutionTick)]
            assert len(ticks) == 1 and ticks[0].result is directive
            assert accepted is not None
            assert step.after.activity.execution.plan == accepted
            moved += bool(directive.path)
    assert moved > 1000


def test_states_and_what_belongs_to_them_agree(drives):
    for run in drives:
        for step in run.steps:
            state = step.after
            asked = None if state.question is None else state.question.kind
            assert isinstance(state.activity, AwaitingApproval) is (asked is QuestionKind.APPROVAL)
            if isinstance(state.activity, Executing):
                assert isinstance(state.posture, Driving)
                assert state.intervention is not None
            if isinstance(state.posture, MinimalRisk):
                assert isinstance(step.directive, SafeStop)
            if not isinstance(state.posture, Driving) or isinstance(state.activity, AwaitingGap):
                assert state.intervention is not None
            if run.observes:
                assert step.directive == CONTINUE


def test_every_state_finds_its_way_out(drives):
    """After it all, on a free street, with an operator who answers, nothing is left under way."""
    for run in drives:
        state = run.steps[-1].after
        assert state.intervention is None, run.seed
        assert state.question is None
        assert isinstance(state.activity, Monitoring)
        assert isinstance(state.posture, Driving)


def test_every_way_of_the_table_is_taken_by_some_drive(drives):
    taken = set()
    for run in drives:
        for step in run.steps:
            taken.add((step.before.activity.name, step.after.activity.name))
            taken.add((step.before.posture.name, step.after.posture.name))
    missing = (set(ACTIVITIES) | set(POSTURES)) - taken
    assert not missing


@pytest.mark.parametrize("seed", range(6 if WHOLE else 3))
def test_every_record_is_derived_again_step_by_step(seed, tmp_path):
    run = random_drive(1000 + seed, Recorder(tmp_path), seconds=16.0)
    for file in run.files:
        report = replay(file)
        assert report.findings == []
    assert len(run.files) == run.steps[-1].after.interventions


def test_the_page_of_states_is_the_table():
    file = Path(__file__).parents[3] / "docs" / "states.md"
    assert file.read_text(encoding="utf-8") == page(), (
        "python -m stucksolver.solver.state_machine.table > docs/states.md"
    )
