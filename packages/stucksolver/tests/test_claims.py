"""What people say of the world: what it changes within the guard, and what it never does."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from grids import sample
from stucksolver import StuckSolver
from stucksolver.ladder.ladder import GuidancePolicy
from stucksolver.plan import Execute, WaitReason
from stucksolver.scene import LineKind, ObjectKind
from stucksolver.solver import EventKind, QuestionError
from stucksolver.solver.state_machine.transition import first_state
from worlds import LANE_M, World, drive, ladder, red_light, straight_road, thing

TWO_WAY = straight_road()
TWO_LANES = straight_road(left=LineKind.BROKEN, oncoming=None)


def started(result):
    return [e.time_s for e in result.events if e.kind is EventKind.STARTED]


def behind_a_van():
    return World(TWO_LANES, [thing("van", 75.0, kind=ObjectKind.VAN, stationary_s=0.0)], x=66.0, cruise_mps=0.0)


def behind_a_car():
    return World(TWO_LANES, [thing("car", 75.0)], x=66.0, cruise_mps=0.0)


@cache
def begun_in_silence(world):
    """When a plan starts there if nobody says anything."""
    return tuple(started(drive(world(), 20.0)))


@pytest.mark.integration
@pytest.mark.parametrize(
    "words", sample(["he's unloading, that takes an hour", "that one has been parked here since Monday"], 1)
)
def test_who_is_said_to_stay_is_passed_sooner(words):
    told = drive(behind_a_van(), 20.0, words={2.0: words})
    assert started(told)[0] < begun_in_silence(behind_a_van)[0] - 3.0
    assert told.nearest_m > 0.3


def test_no_claim_makes_a_queue_an_obstruction():
    def world():
        lead = thing("lead", 75.0, stationary_s=12.0, moved_s_ago=12.0)
        return World(TWO_WAY, [lead], x=66.0, cruise_mps=0.0)

    assert not started(drive(world(), 20.0, words={2.0: "he's unloading, that takes an hour"}))


@pytest.mark.integration
@pytest.mark.parametrize(
    "words", sample(["the driver is just coming back", "look, the owner is walking to his car"], 1)
)
def test_who_is_said_to_come_back_is_waited_for(words):
    alone = begun_in_silence(behind_a_car)
    told = started(drive(behind_a_car(), 46.0, words={0.5: words}))
    assert alone and alone[0] < 10.0
    assert told and 30.0 < told[0] < 45.0


def bag(confidence, kind=ObjectKind.BAG):
    return thing(
        "bag", 75.0, kind=kind, height=0.12, kind_confidence=confidence, seen_for_s=20.0, length=0.4, width=0.4
    )


def over_it(what, words=None):
    world = World(straight_road(oncoming=None), [what], x=64.0, cruise_mps=0.0)
    seen = drive(world, 15.0, words=words)
    plans = [e.decision.plan for e in seen.events if e.kind is EventKind.DECIDED and e.verdict and e.verdict.accepted]
    return any(b.name == "drive_over" for plan in plans for b in plan.behaviors)


@pytest.mark.integration
@pytest.mark.parametrize("words", sample(["that's only a bag", "it's just a plastic bag blowing about"], 1))
def test_claim_soft_object_uncertain_bag_is_driven_over(words):
    """A bag of low confidence is driven over after a person says that it is only a bag."""
    assert not over_it(bag(0.6))
    assert over_it(bag(0.6), {2.0: words})


@pytest.mark.parametrize("kind", [ObjectKind.UNKNOWN, ObjectKind.PROP, ObjectKind.DEBRIS, ObjectKind.ANIMAL])
def test_nothing_else_becomes_a_bag_by_words(kind):
    assert not over_it(bag(0.99, kind), {2.0: "that's only a bag"})


def test_claim_soft_object_very_uncertain_bag_is_avoided():
    """A bag with a confidence of 0.4 is not driven over, whatever a person says."""
    assert not over_it(bag(0.4), {2.0: "that's only a bag"})


@pytest.mark.parametrize("words", sample(["that is not a bag", "I don't think that's a bag", "no bag, that"], 1))
def test_that_it_is_no_bag_confirms_nothing(words):
    assert not over_it(bag(0.6), {2.0: words})


@pytest.mark.integration
@pytest.mark.parametrize(
    "words", sample(["the road is clear", "nobody is coming, it's all clear", "the way is free"], 1)
)
def test_that_the_road_is_clear_never_replaces_sight(words):
    world, left = World(TWO_WAY, [thing("car", 75.0)], x=66.0, cruise_mps=0.0, sight_m=45.0), []
    drive(world, 20.0, words={2.0: words, 10.0: words}, every_tick=lambda w: left.append(w.y))
    assert max(left) < LANE_M / 2


def at_red(words, answer=None, seconds=25.0):
    """Before a light that stays red; `answer` is called with the solver and each new question. Events, questions, x."""
    world = World(straight_road(oncoming=None), controls=(red_light(3.0),), x=60.0, cruise_mps=0.0)
    told, asked, said = [], [], dict(words)
    with StuckSolver(world.scene, clock="lockstep", on_event=told.append) as solver:
        for _ in range(round(seconds / world.dt)):
            for when in [when for when in said if when <= world.time_s]:
                solver.guide(said.pop(when))
            before = world.x
            world.drive(solver.step(world.status(), world.surroundings))
            moved = world.x - before
            world.controls = tuple(c.model_copy(update={"distance_m": c.distance_m - moved}) for c in world.controls)
            question = solver.pending_question
            if question is not None and question.id not in [q.id for q in asked]:
                asked.append(question)
                if answer is not None:
                    answer(solver, question)
            if world.x > 70.0:
                break
            assert world.speed < 2.5
    return [e.time_s for e in told if e.kind is EventKind.STARTED], asked, world.x


@pytest.mark.parametrize("words", sample(["that light has been broken for days", "this signal is stuck on red"], 1))
def test_claim_broken_light_asks_operator_at_once(words):
    """The operator is asked at once about a red light that a person calls broken."""
    begun, asked, _ = at_red({5.0: words})
    assert [(q.to, q.needs) for q in asked] == [("operator", ("red_light",))]
    assert asked[0].time_s < 8.0
    assert not begun


@pytest.mark.integration
def test_an_operators_yes_lets_it_creep_across():
    begun, _, x = at_red({5.0: "that light has been broken for days"}, lambda s, q: s.approve(q.id, by="operator"))
    assert begun and x > 70.0


def test_a_passenger_can_not_release_a_red_light():
    def tries(solver, question):
        with pytest.raises(QuestionError, match="for the operator"):
            solver.approve(question.id, by="passenger")

    begun, asked, _ = at_red({5.0: "that light has been broken for days"}, tries)
    assert asked and not begun


def test_red_light_without_claim_asks_no_person():
    """Without a claim, no person is asked about a light that may still change."""
    assert at_red({}, seconds=60.0)[1] == []


def test_hurry_shortens_the_wait_for_others_and_no_duty():
    climb = first_state(ladder(), frozenset({"reasoner"})).escalation
    hurried = replace(climb, patience=0.5)
    for reason in (WaitReason.LIGHT, WaitReason.PEOPLE, WaitReason.YIELD, WaitReason.STOP_SIGN):
        assert hurried.note_wait(reason, 0.0).expired_waits(100.0) == climb.note_wait(reason, 0.0).expired_waits(100.0)
    assert climb.note_wait(WaitReason.QUEUE, 0.0).expired_waits(200.0) == frozenset()
    assert hurried.note_wait(WaitReason.QUEUE, 0.0).expired_waits(200.0) == {WaitReason.QUEUE}


def test_a_claim_is_forgotten_after_its_time():
    brief = ladder(words=GuidancePolicy(claims_s=3.0))
    world = World(straight_road(oncoming=None), [bag(0.6)], x=64.0, cruise_mps=0.0)
    world.objects = [world.objects[0].model_copy(update={"kind_confidence": 0.3})]

    def clearer(w):
        if w.time_s > 10.0:
            w.objects = [w.objects[0].model_copy(update={"kind_confidence": 0.6})]

    seen = drive(world, 20.0, ladder=brief, words={2.0: "that's only a bag"}, every_tick=clearer)
    assert not started(seen)


@pytest.mark.integration
def test_that_somebody_waves_us_through_ends_a_stand_off_sooner():
    def world():
        lead = thing("other", 72.0, 0.0, yaw=1.57, stationary_s=5.0)
        return World(straight_road(oncoming=None), [lead], x=62.0, cruise_mps=0.0)

    alone, told = (started(drive(world(), 20.0, words=w)) for w in ({}, {1.5: "he waves us through"}))
    assert told and (not alone or told[0] < alone[0] - 2.0)


@pytest.mark.integration
def test_red_light_approved_path_is_marked_over_red():
    """The path over an approved red light is sent with `over_red`."""
    orders = []
    world = World(straight_road(oncoming=None), controls=(red_light(3.0),), x=60.0, cruise_mps=0.0)
    with StuckSolver(world.scene, clock="lockstep") as solver:
        solver.guide("that light has been broken for days")
        for _ in range(200):
            orders.append(solver.step(world.status(), world.surroundings))
            world.drive(orders[-1])
            if solver.pending_question is not None:
                solver.approve(by="operator")
    driven = [order for order in orders if isinstance(order, Execute) and order.path]
    assert driven and all(item.over_red for item in driven)


def test_operator_without_answer_is_asked_once_per_minute():
    """An operator that does not answer is asked again only after a while."""
    _, asked, _ = at_red({5.0: "that light has been broken for days"}, seconds=60.0)
    assert [q.needs for q in asked].count(("red_light",)) == 1


@pytest.mark.integration
def test_red_light_past_limit_unanswered_requests_assistance():
    """Remote assistance is requested if no person answers about a light that has been red for too long."""
    world = World(straight_road(oncoming=None), controls=(red_light(3.0),), x=60.0, cruise_mps=0.0)
    told = []
    with StuckSolver(world.scene, clock="lockstep", ladder=ladder("evaluation"), on_event=told.append) as solver:
        while world.time_s < 225.0:
            world.drive(solver.step(world.status(), world.surroundings))
    assert any(e.kind is EventKind.ASKED and e.question.needs == ("red_light",) for e in told)
    assert "request_assistance" in [e.text for e in told if e.kind is EventKind.STARTED]
