"""The reasoner is an untrusted function: whatever it does, nothing is touched and the loop goes on."""

from __future__ import annotations

import threading

import pytest

from grids import each_value
from stucksolver.plan import CONTINUE, Execute, GuidanceIntent, RecoveryPlan
from stucksolver.plan.behaviors import BorrowOncomingLane, ChangeLane, KeepLane, Wait
from stucksolver.reasoners import ReasonerAnswer, ReasonerError
from stucksolver.scene import LineKind
from stucksolver.solver import EventKind
from worlds import LANE_M, World, drive, noticed, straight_road, thing

TWO_WAY = straight_road()
MULTI = straight_road(left=LineKind.BROKEN)


class Says:
    """Calls a function for every scene."""

    name = "says"

    def __init__(self, answer):
        self.answer = answer

    def decide(self, request):
        return ReasonerAnswer(self.answer(request.scene), self.name)


def planning(*behaviors, **plan):
    """A reasoner that answers everything with one plan."""
    fixed = RecoveryPlan(behaviors=behaviors, **plan)
    return Says(lambda scene: noticed(scene).model_copy(update={"plan": fixed}))


def raising(error):
    def answer(scene):
        raise error

    return Says(answer)


def busy_road(road=TWO_WAY):
    traffic = [thing(f"car{k}", 120.0 + 60.0 * k, LANE_M, speed=-9.0) for k in range(4)]
    return World(road, [thing("lead", 75.0), thing("parked too", 110.0, -1.2), *traffic])


@pytest.mark.parametrize(
    "error", [ReasonerError("no answer"), ValueError("boom"), KeyError("x"), SystemExit(1), RecursionError()]
)
def test_a_reasoner_that_raises_leaves_the_vehicle_to_its_stack(error):
    seen = drive(busy_road(), 15.0, reasoner=raising(error))
    assert set(map(type, seen.directives)) == {type(CONTINUE)}
    assert 3 <= seen.kinds().count(EventKind.FAILED) <= 8
    assert "the reasoner gave no answer" in seen.texts(EventKind.FAILED)[0]


@pytest.mark.parametrize(
    "answer", [None, "change_lane", 7, {"plan": None}, RecoveryPlan(behaviors=(Wait(duration_s=1),))]
)
def test_an_answer_that_is_no_decision_is_no_answer(answer):
    seen = drive(busy_road(), 15.0, reasoner=Says(lambda scene: answer))
    assert set(map(type, seen.directives)) == {type(CONTINUE)}
    assert 3 <= seen.kinds().count(EventKind.FAILED) <= 8


NONSENSE = {
    "a borrow past nobody": (BorrowOncomingLane(past_object_id="nobody", speed_mps=11.0),),
    "a lane that does not exist": (ChangeLane(side="right", distance_m=150.0, speed_mps=11.0),),
    "into the car ahead": (KeepLane(distance_m=150.0, speed_mps=11.0),),
    "waiting for ever": (Wait(duration_s=20.0),) * 6,
    "to and fro": (
        ChangeLane(side="left", distance_m=15.0, speed_mps=5.0),
        ChangeLane(side="right", distance_m=15.0, speed_mps=5.0),
    )
    * 3,
    "a borrow in an instant": (Wait(duration_s=0.5), BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)),
    "borrowing past oncoming traffic": (BorrowOncomingLane(past_object_id="car3", speed_mps=5.0),),
}


@pytest.mark.integration
@pytest.mark.parametrize(("what", "road"), each_value(NONSENSE, [TWO_WAY, MULTI]))
def test_nonsense_touches_nobody(what, road):
    seen = drive(busy_road(road), 30.0, reasoner=planning(*NONSENSE[what]))
    assert seen.nearest_m > 0.25
    assert len(seen.directives) == 600


@pytest.mark.slow
@pytest.mark.integration
@pytest.mark.parametrize(
    ("phase", "clock"), each_value((0.0, 13.0, 27.0, 41.0), ("lockstep", "latency:0.7", "latency:3"))
)
def test_a_reasoner_that_always_borrows_never_meets_the_oncoming_traffic(clock, phase):
    world = busy_road()
    world.objects = world.objects[:2] + [
        thing(f"car{k}", 100.0 + phase + 55.0 * k, LANE_M, speed=-7.0 - k) for k in range(5)
    ]
    seen = drive(world, 45.0, reasoner=planning(BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)), clock=clock)
    assert seen.nearest_m > 0.3


def test_a_reasoner_that_always_borrows_does_it_only_when_immobilized():
    world = World(TWO_WAY, [thing("lead", 300.0)], speed=8.0)
    seen = drive(world, 10.0, reasoner=planning(BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)))
    assert seen.events == []


def test_a_reasoner_that_never_answers_costs_nothing_but_the_recovery():
    for_ever, calls = threading.Event(), []

    def hang(scene):
        calls.append(1)
        for_ever.wait(60.0)

    try:
        seen = drive(busy_road(), 20.0, reasoner=Says(hang), clock="wall")
    finally:
        for_ever.set()
    assert set(map(type, seen.directives)) == {type(CONTINUE)}
    # It is given up after the rung's deadline, and not called again while it hangs. The passenger is told before.
    kinds = [kind for kind in seen.kinds() if kind is not EventKind.WAITING]
    assert kinds[:3] == [EventKind.TRIGGERED, EventKind.FAILED, EventKind.TRIGGERED]
    assert "no answer within 10 s" in seen.texts(EventKind.FAILED)[0]
    assert "still busy with an older question" in seen.texts(EventKind.FAILED)[1]
    assert calls == [1]


def test_a_behavior_that_the_stack_does_not_offer_is_refused():
    world = busy_road()
    world.objects = world.objects[:1]
    world.offers = ("wait", "keep_lane")
    seen = drive(world, 15.0, reasoner=planning(BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)))
    assert not any(isinstance(d, Execute) for d in seen.directives)
    assert "behavior borrow_oncoming_lane is not offered" in str(seen.events[1].verdict)


def test_route_start_not_in_scene_is_rejected():
    plan = planning(KeepLane(distance_m=5.0, speed_mps=2.0), replan_route=True, route_start="the moon")
    seen = drive(busy_road(), 15.0, reasoner=plan)
    assert set(map(type, seen.directives)) == {type(CONTINUE)}
    assert "waypoint the moon" in str(seen.events[1].verdict)


@pytest.mark.parametrize("intent", [GuidanceIntent.WAIT, GuidanceIntent.UNCLEAR, GuidanceIntent.OVERTAKE])
def test_an_answer_to_words_that_nobody_said_changes_nothing(intent):
    def answer(scene):
        decision = noticed(scene)
        analysis = decision.analysis.model_copy(update={"guidance_intent": intent})
        return decision.model_copy(update={"analysis": analysis, "plan": None})

    seen = drive(busy_road(), 10.0, reasoner=Says(answer))
    assert EventKind.DECIDED in seen.kinds()
    assert EventKind.GUIDANCE_ENDED not in seen.kinds()


@pytest.mark.integration
def test_car_appearing_before_commit_point_ends_plan():
    world = World(TWO_WAY, [thing("lead", 75.0)])
    stood = []

    def appears(world):
        stood.append(world.speed == 0.0)
        if len(world.objects) == 1 and any(stood) and world.speed > 0.0:
            world.objects.append(thing("sudden", world.x + 70.0, LANE_M, speed=-9.0))

    seen = drive(world, 40.0, every_tick=appears)
    assert "oncoming_gap" in seen.texts(EventKind.ABORTED)[0]
    assert seen.nearest_m > 0.3
    assert world.x > 100.0


@pytest.mark.integration
def test_stack_that_does_not_move_ends_plan_by_timeout():
    """A stack that does not move ends the plan when its time is over."""
    world = World(TWO_WAY, [thing("lead", 75.0)])
    seen = drive(world, 5.0)
    frozen = World(TWO_WAY, [thing("lead", 75.0)], x=world.x, cruise_mps=0.0)
    frozen._along = lambda directive: None
    seen = drive(frozen, 60.0)
    assert "timeout" in seen.texts(EventKind.ABORTED)[0]
    assert frozen.x == world.x
