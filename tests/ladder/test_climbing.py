"""How the ladder is climbed: waits, tries, people, the stop, and the way back down."""

from __future__ import annotations

import math
import threading

import pytest
from worlds import LANE_M, World, drive, ladder, red_light, straight_road, stubborn, thing

from stucksolver import CONTINUE, SafeStop, StuckSolver
from stucksolver.decision import Execute, RecoveryPlan
from stucksolver.decision.behaviors import BackUp, BorrowOncomingLane, ChangeLane, KeepLane, Wait
from stucksolver.guard import RejectCode
from stucksolver.ladder import Resume, Waits, profile
from stucksolver.reason import ReasonerError, RuleReasoner
from stucksolver.scene import LineKind
from stucksolver.solver import EventKind, QuestionError, QuestionKind
from stucksolver.solver.failures import Failures

TWO_WAY, SOLID = straight_road(), straight_road(oncoming=LineKind.SOLID)
QUICK = {"rules": {"tries": 2, "cooldown_s": 0.5, "repair_rounds": 0}, "passenger": {"within_s": 4.0}}
STANDING_STILL = {"cruise_mps": 0.0}


class Says:
    """Calls a function for every scene, and counts."""

    def __init__(self, answer, name="says"):
        self.answer, self.name, self.calls = answer, name, 0

    def decide(self, scene):
        self.calls += 1
        return self.answer(scene)


def planning(*behaviors):
    plan = {"behaviors": behaviors}
    return Says(lambda scene: _with_plan(RuleReasoner().decide(scene), plan))


def _with_plan(decision, plan):
    return decision.model_copy(update={"plan": RecoveryPlan(**plan)})


def helpless():
    def answer(scene):
        raise ReasonerError("no idea")

    return Says(answer)


def waits(**longest):
    usual = profile("default").waits
    reasons = {
        r: p.model_copy(update={"longest_s": longest.get(r.value, p.longest_s)}) for r, p in usual.reasons.items()
    }
    return Waits(**{**usual.model_dump(exclude={"reasons", "otherwise"}), "reasons": reasons})


def stuck(road=TWO_WAY, **more):
    return World(road, [thing("lead", 75.0)], x=66.0, **more)


# ---- waits


def test_a_red_light_is_no_immobilization():
    world = World(TWO_WAY, controls=(red_light(8.0),), **STANDING_STILL)
    seen = drive(world, 100.0)
    assert set(map(type, seen.directives)) == {type(CONTINUE)}
    assert set(seen.kinds()) == {EventKind.TRIGGERED, EventKind.DECIDED}
    assert all(e.waiting and e.intervention is None for e in seen.events if e.decision)


def test_a_wait_that_outlives_its_reason_counts():
    world = World(TWO_WAY, controls=(red_light(8.0),), **STANDING_STILL)
    seen = drive(world, 30.0, ladder=ladder(rungs=QUICK, waits=waits(light=10.0)))
    assert isinstance(seen.directives[-1], SafeStop)
    first = next(e for e in seen.events if e.intervention)
    assert 10.0 <= first.time_s <= 15.0
    # A red light is never passed on the way there.
    assert not any(isinstance(d, Execute) for d in seen.directives)


def test_a_model_is_not_asked_about_a_red_light():
    model = helpless()
    world = World(TWO_WAY, controls=(red_light(8.0),), **STANDING_STILL)
    drive(world, 30.0, reasoner=model)
    assert model.calls == 0


def test_a_model_that_always_finds_a_reason_to_wait_is_believed_only_for_so_long():
    def always_people(scene):
        decision = RuleReasoner().decide(scene)
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


def test_a_model_is_asked_when_the_rules_are_at_their_end():
    model = Says(RuleReasoner().decide, "clever")
    world = stuck()
    seen = drive(world, 20.0, reasoner=helpless(), models={"model": model}, ladder=ladder(rungs=QUICK))
    assert EventKind.RECOVERED in seen.kinds()
    decided = next(e for e in seen.events if e.kind is EventKind.DECIDED)
    assert (decided.rung, decided.reasoner) == ("model", "clever")


def test_tries_are_counted_and_pauses_kept():
    seen = drive(stuck(**STANDING_STILL), 8.0, reasoner=helpless(), ladder=ladder(rungs={"rules": {"tries": 3}}))
    failed = [e.time_s for e in seen.events if e.kind is EventKind.FAILED and e.rung == "rules"]
    assert len(failed) == 3
    assert failed[1] - failed[0] == pytest.approx(2.05, abs=0.06)
    assert seen.texts(EventKind.ESCALATED) == ["to the rung passenger"]


def test_traffic_that_will_go_on_uses_up_no_tries():
    """A stream of oncoming cars refuses the plan again and again; that is no reason to call for help."""
    stream = [thing(f"car{k}", 110.0 + 45.0 * k, LANE_M, speed=-9.0) for k in range(12)]
    world = World(TWO_WAY, [thing("lead", 75.0), *stream], x=66.0, sight_m=600.0)
    pushy = Says(
        lambda scene: _with_plan(
            RuleReasoner().decide(scene), {"behaviors": (BorrowOncomingLane(past_object_id="lead", speed_mps=5.0),)}
        )
    )
    seen = drive(world, 70.0, reasoner=pushy, ladder=ladder(rungs={"rules": {"tries": 2}}))
    refusals = [e.verdict for e in seen.events if e.verdict and not e.verdict.accepted]
    assert len(refusals) > 4
    assert EventKind.ESCALATED not in seen.kinds()
    assert EventKind.RECOVERED in seen.kinds()
    assert seen.nearest_m > 0.3


@pytest.mark.parametrize("spacing_m", [18.0, 24.0])
def test_in_a_stream_of_cars_beside_us_a_plan_begins_in_the_first_gap_and_meets_nobody(spacing_m):
    """The cars are of the kind that never brakes; they are as quick as the plan."""
    stream = [thing(f"car{k}", 62.0 - spacing_m * k, LANE_M, speed=5.0) for k in range(-2, 14) if k != 3]
    world = World(straight_road(left=LineKind.BROKEN, oncoming=None), [thing("lead", 59.7, hazard=True), *stream])
    seen = drive(world, 40.0, ladder=profile("evaluation"))
    assert seen.kinds().count(EventKind.STARTED) == 1
    assert EventKind.RECOVERED in seen.kinds()
    assert seen.nearest_m > 0.3


def test_a_plan_that_ran_out_of_time_is_not_started_again():
    world = stuck()
    world._along = lambda directive: None
    world.cruise_mps = 0.0
    seen = drive(world, 60.0, ladder=stubborn())
    assert seen.kinds().count(EventKind.STARTED) == 1
    again = [e.verdict for e in seen.events if e.verdict and not e.verdict.accepted]
    assert again and all("failed before: timeout" in str(v) for v in again)


def test_a_plan_that_was_done_and_changed_nothing_is_not_repeated():
    seen = drive(stuck(), 30.0, reasoner=planning(Wait(duration_s=2.0)), ladder=stubborn())
    assert seen.kinds().count(EventKind.STARTED) == 1
    assert seen.kinds().count(EventKind.USELESS) == 1
    again = [str(e.verdict) for e in seen.events if e.verdict and not e.verdict.accepted]
    assert again and all("the vehicle did not get on" in text for text in again)
    assert any(a.outcome.startswith("it was done") for e in seen.events if e.scene for a in e.scene.attempts)


def test_moves_that_only_prepare_are_not_called_useless():
    seen = drive(stuck(), 20.0, reasoner=planning(BackUp(distance_m=2.0)), ladder=stubborn())
    assert EventKind.FINISHED in seen.kinds()
    assert EventKind.USELESS not in seen.kinds()


def test_walking_pace_makes_another_plan_of_one_that_failed():
    def plan(speed):
        return RecoveryPlan(behaviors=(ChangeLane(side="left", distance_m=30.0, speed_mps=speed),))

    failures = Failures(remembered=5)
    failures.useless(plan(5.0))
    assert [r.code for r in failures.against(plan(4.0)).rejects] == [RejectCode.REPEATED]
    assert failures.against(plan(2.0)) is None


def test_the_counters_start_anew_only_after_15_m():
    world = stuck()
    far = []

    def creeps(world):
        """Gets on by a few metres by itself, then stands again."""
        if 10.0 < world.time_s < 12.0 and world.x < 76.0:
            world.objects = [thing("lead", 85.0)]
            world.cruise_mps = 8.0
        far.append(world.x)

    seen = drive(world, 30.0, reasoner=helpless(), ladder=ladder(rungs=QUICK), every_tick=creeps)
    assert EventKind.CLOSED not in seen.kinds()
    assert seen.texts(EventKind.ESCALATED)[-1] == "to the rung remote"


def test_after_a_recovery_the_next_immobilization_is_a_new_intervention():
    world = World(TWO_WAY, [thing("lead", 75.0), thing("second", 180.0)], x=66.0, sight_m=500.0)
    seen = drive(world, 50.0)
    closed = [e for e in seen.events if e.kind is EventKind.CLOSED]
    assert [e.intervention for e in closed] == [1, 2]
    assert {e.rung for e in seen.events} == {"rules"}


# ---- people


def test_the_passenger_is_asked_and_may_answer_in_words():
    world = stuck()
    told = []

    class OnlyWhenAsked:
        name = "shy"

        def decide(self, scene):
            if scene.guidance is None:
                raise ReasonerError("no idea")
            return RuleReasoner().decide(scene)

    with StuckSolver(
        world.scene,
        reasoner=OnlyWhenAsked(),
        clock="lockstep",
        ladder=ladder(rungs=QUICK | {"passenger": {}}),
        on_event=told.append,
    ) as solver:
        for _ in range(round(30.0 / world.dt)):
            world.drive(solver.step(world.status(), world.surroundings))
            question = solver.pending_question
            if question is not None and question.kind is QuestionKind.ADVICE and world.time_s > 5.0:
                assert "car lead blocks the way" in question.text
                with pytest.raises(QuestionError, match="call guide"):
                    solver.approve()
                solver.guide("please go around it")
                world.time_s += 1e-3
    assert EventKind.RECOVERED in [e.kind for e in told]
    assert world.x > 100.0


def solid_line(seconds, answer, **options):
    """Stuck behind a parked car at a solid line; `answer` gets the solver whenever a question is open."""
    world = World(SOLID, [thing("lead", 75.0)], x=58.0, **STANDING_STILL)
    told = []
    with StuckSolver(world.scene, clock="lockstep", on_event=told.append, **options) as solver:
        for _ in range(round(seconds / world.dt)):
            if solver.pending_question is not None:
                answer(solver)
            world.drive(solver.step(world.status(), world.surroundings))
    return world, told


def kinds(told):
    return [e.kind for e in told]


def test_a_solid_line_is_crossed_with_the_passengers_yes():
    asked = []

    def yes(solver):
        asked.append(solver.pending_question)
        solver.approve(solver.pending_question.id)

    world, told = solid_line(11.0, yes)
    assert (asked[0].kind, asked[0].to, asked[0].needs) == (QuestionKind.APPROVAL, "passenger", ("solid_line",))
    assert kinds(told).count(EventKind.ASKED) == 1
    assert EventKind.RECOVERED in kinds(told)
    assert world.x > 80.0


def test_without_a_yes_it_is_not_crossed_and_a_no_is_not_asked_again():
    world, told = solid_line(60.0, lambda solver: solver.deny() if solver.pending_question.plan else None)
    assert EventKind.STARTED not in [e.kind for e in told if e.text != "pull_over"]
    assert kinds(told).count(EventKind.ANSWERED) == 1
    assert [e.question.kind for e in told if e.kind is EventKind.ASKED].count(QuestionKind.APPROVAL) == 1
    assert abs(world.y) < LANE_M / 2


def test_a_question_that_nobody_answers_is_withdrawn():
    brief = profile("default").asking.model_copy(update={"approval_within_s": 3.0})
    _, told = solid_line(10.0, lambda solver: None, ladder=ladder(asking=brief))
    asked = next(e for e in told if e.kind is EventKind.ASKED)
    gone = next(e for e in told if e.kind is EventKind.CANCELLED)
    assert gone.time_s - asked.time_s == pytest.approx(3.0, abs=0.15)


def test_what_needs_the_operator_is_not_released_by_the_passenger():
    def tries(solver):
        if solver.pending_question.to == "operator":
            with pytest.raises(QuestionError, match="for the operator"):
                solver.approve(by="passenger")

    _, told = solid_line(12.0, tries, ladder=ladder(solid_line="operator"))
    assert EventKind.ASKED in kinds(told)
    assert EventKind.STARTED not in kinds(told)
    _, told = solid_line(11.0, lambda s: s.approve(by="operator"), ladder=ladder(solid_line="operator"))
    assert EventKind.RECOVERED in kinds(told)


def test_a_yes_to_nothing_is_refused():
    solver = StuckSolver(lambda: None)
    with pytest.raises(QuestionError, match="nothing is asked"):
        solver.approve()
    with pytest.raises(QuestionError, match="nothing is asked"):
        solver.deny("q1")


# ---- the stop


def stopped_world(resume, change, seconds=40.0, **options):
    """Blocked by a wall of a truck until `change` says otherwise."""
    world = World(straight_road(oncoming=None), [thing("truck", 76.0)], x=66.0)
    rungs = QUICK | {"passenger": None, "remote": {"resume": resume, "look_every_s": 1.0, "pull_over": False}}
    told, directives = [], []
    with StuckSolver(world.scene, clock="lockstep", ladder=ladder(rungs=rungs), on_event=told.append, **options) as it:
        for _ in range(round(seconds / world.dt)):
            change(world, it)
            directive = it.step(world.status(), world.surroundings)
            directives.append(directive)
            world.drive(CONTINUE if not isinstance(directive, Execute) else directive)
            if isinstance(directive, SafeStop):
                world.speed = 0.0
    return world, told, directives


def goes_away(world, solver):
    if world.time_s > 20.0:
        world.objects = []


def test_at_the_end_it_stops_safely_and_calls_for_help():
    _, told, directives = stopped_world(Resume.OPERATOR, lambda world, solver: None, 25.0)
    assert isinstance(directives[-1], SafeStop)
    call = next(e for e in told if e.kind is EventKind.ASKED)
    assert (call.question.kind, call.question.to) == (QuestionKind.ASSISTANCE, "operator")
    assert "truck" in call.text


def test_only_the_operator_ends_a_stop_that_is_theirs_to_end():
    _, told, directives = stopped_world(Resume.OPERATOR, goes_away)
    assert isinstance(directives[-1], SafeStop)

    def with_yes(world, solver):
        goes_away(world, solver)
        if world.time_s > 30.0 and solver.pending_question is not None:
            solver.approve(by="operator")

    _, told, directives = stopped_world(Resume.OPERATOR, with_yes, 45.0)
    assert EventKind.RELEASED in kinds(told)
    assert directives[-1] is CONTINUE


def test_a_free_way_ends_the_stop_where_the_ladder_says_so():
    _, told, directives = stopped_world(Resume.CLEAR, goes_away)
    released = next(e for e in told if e.kind is EventKind.RELEASED)
    assert 20.0 < released.time_s < 23.0
    assert directives[-1] is CONTINUE
    assert EventKind.CLOSED in kinds(told)


def test_a_new_plan_ends_the_stop_where_the_ladder_says_so():
    def road_opens(world, solver):
        if world.time_s > 20.0:
            world.road = TWO_WAY

    world, told, _ = stopped_world(Resume.PLAN, road_opens, 45.0)
    assert "a plan was accepted" in [e.text for e in told if e.kind is EventKind.RELEASED]
    assert world.x > 90.0
    world, told, directives = stopped_world(Resume.CLEAR, road_opens, 45.0)
    assert isinstance(directives[-1], SafeStop)


def test_no_words_end_a_stop_that_is_the_operators_and_the_call_stays_open():
    def words(world, solver):
        if world.time_s == 15.0:
            solver.guide("go around it")
            world.road = TWO_WAY

    _, told, directives = stopped_world(Resume.OPERATOR, words, 25.0)
    ended = next(e.text for e in told if e.kind is EventKind.GUIDANCE_ENDED)
    assert "only the operator" in ended
    assert isinstance(directives[-1], SafeStop)


def test_a_passengers_words_may_end_the_stop_where_the_ladder_says_so():
    def words(world, solver):
        if world.time_s == 15.0:
            solver.guide("go around it")
            world.road = TWO_WAY

    world, told, _ = stopped_world(Resume.CLEAR, words, 35.0)
    assert "a plan was accepted" in [e.text for e in told if e.kind is EventKind.RELEASED]
    assert world.x > 90.0


# ---- never in the way


def test_a_question_is_dropped_and_its_reasoner_told_when_the_situation_clears():
    class Slow:
        name = "slow"

        def __init__(self):
            self.let, self.cancelled = threading.Event(), 0

        def decide(self, scene):
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


def test_plans_that_only_wait_do_not_wait_for_ever():
    seen = drive(stuck(), 60.0, reasoner=planning(Wait(duration_s=2.0)), ladder=ladder(rungs=QUICK))
    assert isinstance(seen.directives[-1], SafeStop)


def test_a_refused_plan_says_which_rule_it_broke():
    into = planning(KeepLane(distance_m=50.0, speed_mps=8.0))
    seen = drive(stuck(), 6.0, reasoner=into)
    codes = {r.code for e in seen.events if e.verdict for r in e.verdict.rejects}
    assert RejectCode.COLLISION in codes
