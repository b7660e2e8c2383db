"""How the ladder is climbed: waits, tries, and the way back down; it is never in the way."""

from __future__ import annotations

import math
import threading

import pytest
from climbing import QUICK, STANDING_STILL, TWO_WAY, Says, helpless, planning, stuck, waits

from grids import sample
from stucksolver import CONTINUE, SafeStop, StuckSolver
from stucksolver.guard import RejectCode
from stucksolver.ladder import profile
from stucksolver.plan import Execute, RecoveryPlan
from stucksolver.plan.behaviors import BackUp, BorrowOncomingLane, ChangeLane, KeepLane, Wait
from stucksolver.reasoners import ReasonerError, SearchReasoner
from stucksolver.scene import LineKind
from stucksolver.solver import EventKind, QuestionKind
from stucksolver.solver.state_machine.history import AttemptHistory
from worlds import LANE_M, World, drive, ladder, noticed, red_light, straight_road, stubborn, thing

# ---- deadlines


def test_a_rungs_deadline_is_told_to_its_reasoner():
    class Slow(Says):
        told = ()

        def decide(self, request):
            self.told = (*self.told, request.deadline_s)
            return super().decide(request)

    model = Slow(lambda scene: noticed(scene), name="slow")
    rungs = {"model": {"deadline_s": 240.0}, "reasoner": {"tries": 1, "cooldown_s": 0.5, "repair_rounds": 0}}
    world = World(TWO_WAY, [thing("lead", 75.0)], x=66.0)
    drive(world, 20.0, ladder=ladder(rungs=rungs), reasoner=helpless(), models={"model": model})
    assert model.calls and set(model.told) == {240.0}


# ---- waits


def test_a_red_light_is_no_immobilization():
    world = World(TWO_WAY, controls=(red_light(8.0),), **STANDING_STILL)
    seen = drive(world, 100.0)
    assert set(map(type, seen.directives)) == {type(CONTINUE)}
    # People are told of one that stays red for long, and nothing else happens.
    assert set(seen.kinds()) == {EventKind.TRIGGERED, EventKind.DECIDED, EventKind.WAITING}
    assert all(e.waiting and e.intervention is None for e in seen.events if e.decision)


def test_a_wait_that_outlives_its_reason_counts():
    world = World(TWO_WAY, controls=(red_light(8.0),), **STANDING_STILL)
    seen = drive(world, 30.0, ladder=ladder(rungs=QUICK, waits=waits(light=10.0)))
    # Nothing is in the path: the vehicle is its driver's, who waits at the light, and help is called.
    assert EventKind.STOPPED not in seen.kinds()
    assert any(e.question is not None and e.question.to == "operator" for e in seen.events)
    first = next(e for e in seen.events if e.intervention)
    assert 10.0 <= first.time_s <= 15.0
    # A red light is never passed on the way there.
    assert not any(isinstance(d, Execute) for d in seen.directives)


def test_a_model_is_not_asked_about_a_red_light():
    model = helpless()
    world = World(TWO_WAY, controls=(red_light(8.0),), **STANDING_STILL)
    drive(world, 30.0, reasoner=model)
    assert model.calls == 0


def test_ladder_endless_legitimate_wait_ends_in_safe_stop():
    """A model that always has a reason to wait is accepted only up to the limit of that wait."""

    def always_people(scene):
        decision = noticed(scene)
        analysis = decision.analysis.model_copy(update={"wait": "people", "immobilized": False})
        return decision.model_copy(update={"analysis": analysis, "plan": None})

    world = stuck()
    seen = drive(world, 40.0, reasoner=Says(always_people), ladder=ladder(rungs=QUICK, waits=waits(people=5.0)))
    assert isinstance(seen.directives[-1], SafeStop)


def test_circling_without_getting_on_counts():
    """A roundabout: at speed all the time, and no new ground."""
    world = World(TWO_WAY, x=60.0, speed=6.0)
    told, angle = [], 0.0
    with StuckSolver(world.scene, clock="lockstep", ladder="default", on_event=told.append) as solver:
        for _ in range(round(40.0 / world.dt)):
            status = world.status().model_copy(update={"progress_m": 60.0, "speed_mps": 6.0})
            solver.step(status, world.surroundings)
            angle += 6.0 * world.dt / 15.0
            world.x, world.y = 60.0 + 15.0 * math.sin(angle), 15.0 * (1 - math.cos(angle))
            world.yaw = angle
            world.time_s = round(world.time_s + world.dt, 6)
            world.frame += 1
    triggered = next(e for e in told if e.kind is EventKind.TRIGGERED)
    assert triggered.text == "progress"
    assert 19.0 < triggered.time_s < 22.0
    assert any(e.intervention for e in told)


# ---- climbing


def test_the_rungs_are_climbed_in_order_and_never_down():
    world = stuck(**STANDING_STILL)
    seen = drive(world, 30.0, reasoner=helpless(), models={"model": helpless()}, ladder=ladder(rungs=QUICK))
    assert seen.texts(EventKind.ESCALATED) == [
        "to the rung model",
        "to the rung passenger",
        "to the rung remote",
    ]
    assert [e.question.kind for e in seen.events if e.kind is EventKind.ASKED] == [
        QuestionKind.ADVICE,
        QuestionKind.ASSISTANCE,
    ]
    first = next(k for k, d in enumerate(seen.directives) if isinstance(d, SafeStop))
    assert len({id(d) for d in seen.directives[first:]}) == 1
    assert "no answer" not in seen.directives[-1].reason


def test_without_a_model_its_rung_is_left_out():
    seen = drive(stuck(**STANDING_STILL), 10.0, reasoner=helpless(), ladder=ladder(rungs=QUICK))
    assert seen.texts(EventKind.ESCALATED)[0] == "to the rung passenger"


@pytest.mark.integration
def test_ladder_first_reasoner_without_plan_queries_model():
    """The model is queried when the first reasoner has no plan."""
    model = SearchReasoner()
    world = stuck()
    seen = drive(world, 20.0, reasoner=helpless(), models={"model": model}, ladder=ladder(rungs=QUICK))
    assert EventKind.RECOVERED in seen.kinds()
    decided = next(e for e in seen.events if e.kind is EventKind.DECIDED)
    assert (decided.rung, decided.reasoner) == ("model", "search")


def test_tries_are_counted_and_pauses_kept():
    seen = drive(stuck(**STANDING_STILL), 8.0, reasoner=helpless(), ladder=ladder(rungs={"reasoner": {"tries": 3}}))
    failed = [e.time_s for e in seen.events if e.kind is EventKind.FAILED and e.rung == "reasoner"]
    assert len(failed) == 3
    assert failed[1] - failed[0] == pytest.approx(2.05, abs=0.06)
    assert seen.texts(EventKind.ESCALATED) == ["to the rung passenger"]


@pytest.mark.release
@pytest.mark.slow
@pytest.mark.integration
def test_traffic_that_will_go_on_uses_up_no_tries():
    """A stream of oncoming cars refuses the plan again and again; that is no reason to call for help."""
    stream = [thing(f"car{k}", 110.0 + 45.0 * k, LANE_M, speed=-9.0) for k in range(8)]
    world = World(TWO_WAY, [thing("lead", 75.0), *stream], x=65.3, sight_m=600.0)
    pushy = planning(BorrowOncomingLane(past_object_id="lead", speed_mps=5.0))
    seen = drive(world, 56.0, reasoner=pushy, ladder=ladder(rungs={"reasoner": {"tries": 2}}))
    refusals = [e.verdict for e in seen.events if e.verdict and not e.verdict.accepted]
    assert len(refusals) > 4
    assert EventKind.ESCALATED not in seen.kinds()
    assert EventKind.RECOVERED in seen.kinds()
    assert seen.nearest_m > 0.3


@pytest.mark.integration
@pytest.mark.parametrize("spacing_m", sample([18.0, 24.0], 1))
def test_ladder_traffic_flow_in_adjacent_lane_starts_in_first_gap(spacing_m):
    """Beside a flow of cars, a plan starts in the first gap and touches no car.

    The cars never brake and are as fast as the plan.
    """
    stream = [thing(f"car{k}", 62.0 - spacing_m * k, LANE_M, speed=5.0) for k in range(-2, 14) if k != 3]
    world = World(straight_road(left=LineKind.BROKEN, oncoming=None), [thing("lead", 59.7, hazard=True), *stream])
    seen = drive(world, 40.0, ladder=profile("evaluation"))
    assert seen.kinds().count(EventKind.STARTED) == 1
    assert EventKind.RECOVERED in seen.kinds()
    assert seen.nearest_m > 0.3


@pytest.mark.integration
def test_ladder_plan_timed_out_is_not_started_again():
    world = stuck()
    world._along = lambda directive: None
    world.cruise_mps = 0.0
    borrow = planning(BorrowOncomingLane(past_object_id="lead", speed_mps=5.5))
    seen = drive(world, 60.0, ladder=stubborn(), reasoner=borrow)
    assert seen.kinds().count(EventKind.STARTED) == 1
    again = [e.verdict for e in seen.events if e.verdict and not e.verdict.accepted]
    assert again and all("failed before: timeout" in str(v) for v in again)


def test_ladder_ineffective_plan_is_not_repeated():
    """A plan that finished without progress of the ego is not started again."""
    seen = drive(stuck(), 30.0, reasoner=planning(Wait(duration_s=2.0)), ladder=stubborn())
    assert seen.kinds().count(EventKind.STARTED) == 1
    assert seen.kinds().count(EventKind.INEFFECTIVE) == 1
    again = [str(e.verdict) for e in seen.events if e.verdict and not e.verdict.accepted]
    assert again and all("the vehicle did not get on" in text for text in again)
    assert any(a.outcome.startswith("it was done") for e in seen.events if e.scene for a in e.scene.attempts)


@pytest.mark.integration
def test_moves_that_only_prepare_are_not_called_useless():
    seen = drive(stuck(), 20.0, reasoner=planning(BackUp(distance_m=2.0)), ladder=stubborn())
    assert EventKind.FINISHED in seen.kinds()
    assert EventKind.INEFFECTIVE not in seen.kinds()


def test_walking_pace_makes_another_plan_of_one_that_failed():
    def plan(speed):
        return RecoveryPlan(behaviors=(ChangeLane(side="left", distance_m=30.0, speed_mps=speed),))

    failures = AttemptHistory(remembered=5).useless(plan(5.0))
    assert [r.code for r in failures.against(plan(4.0)).rejects] == [RejectCode.REPEATED]
    assert failures.against(plan(2.0)) is None


def test_the_counters_start_anew_only_after_15_m():
    world = stuck()
    far = []

    def creeps(world):
        """Gets on by a few meters by itself, then stands again."""
        if 10.0 < world.time_s < 12.0 and world.x < 76.0:
            world.objects = [thing("lead", 85.0)]
            world.cruise_mps = 8.0
        far.append(world.x)

    seen = drive(world, 30.0, reasoner=helpless(), ladder=ladder(rungs=QUICK), every_tick=creeps)
    assert EventKind.CLOSED not in seen.kinds()
    assert seen.texts(EventKind.ESCALATED)[-1] == "to the rung remote"


@pytest.mark.integration
def test_after_a_recovery_the_next_immobilization_is_a_new_intervention():
    world = World(TWO_WAY, [thing("lead", 75.0), thing("second", 180.0)], x=66.0, sight_m=500.0)
    seen = drive(world, 50.0)
    closed = [e for e in seen.events if e.kind is EventKind.CLOSED]
    assert [e.intervention for e in closed] == [1, 2]
    assert {e.rung for e in seen.events} == {"reasoner"}


# ---- never in the way


def test_query_situation_clears_cancels_reasoner():
    """When the situation clears, the query is dropped and its reasoner is cancelled."""

    class Slow:
        name = "slow"

        def __init__(self):
            self.let, self.cancelled = threading.Event(), 0

        def decide(self, request):
            self.let.wait(20.0)
            raise ReasonerError("cancelled")

        def cancel(self):
            self.cancelled += 1
            self.let.set()

    slow, world = Slow(), stuck()

    def clears(world):
        if world.time_s > 3.0:
            world.objects = []

    seen = drive(world, 8.0, reasoner=slow, clock="wall", every_tick=clears)
    assert seen.kinds() == [EventKind.TRIGGERED, EventKind.CANCELLED]
    assert slow.cancelled == 1


def test_an_observer_judges_and_does_nothing():
    world = World(TWO_WAY, [thing("lead", 75.0)], x=66.0, **STANDING_STILL)
    seen = drive(world, 30.0, observe_only=True)
    assert set(map(type, seen.directives)) == {type(CONTINUE)}
    verdicts = [e.verdict for e in seen.events if e.verdict]
    assert verdicts and all(v.accepted for v in verdicts)
    assert not {EventKind.STARTED, EventKind.ASKED, EventKind.STOPPED} & set(seen.kinds())


@pytest.mark.integration
def test_plans_that_only_wait_do_not_wait_for_ever():
    seen = drive(stuck(), 60.0, reasoner=planning(Wait(duration_s=2.0)), ladder=ladder(rungs=QUICK))
    assert isinstance(seen.directives[-1], SafeStop)


def test_a_refused_plan_says_which_rule_it_broke():
    into = planning(KeepLane(distance_m=50.0, speed_mps=8.0))
    seen = drive(stuck(), 6.0, reasoner=into)
    codes = {r.code for e in seen.events if e.verdict for r in e.verdict.rejects}
    assert RejectCode.COLLISION in codes
