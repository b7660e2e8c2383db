"""The solver end to end, in a world with a stand-in vehicle that drives as it is told."""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest

from stucksolver.guard import Guard, GuardPolicy
from stucksolver.plan import CONTINUE, Execute, RecoveryPlan, Replan
from stucksolver.plan.behaviors import BorrowOncomingLane
from stucksolver.reasoners import ReasonerAnswer, SearchReasoner
from stucksolver.scene import CandidateWaypoint, LightState, LineKind, ObjectKind
from stucksolver.solver import EventKind, StuckSolver
from worlds import LANE_M, World, drive, noticed, red_light, straight_road, stubborn, thing

TWO_WAY = straight_road()
MULTI = straight_road(left=LineKind.BROKEN, oncoming=None)


def parked(*others, road=TWO_WAY, **more):
    return World(road, [thing("lead", 75.0), *others], **more)


class AlwaysPasses:
    """Proposes to pass what is ahead in the oncoming lane, also if that was refused."""

    name = "always passes"

    def decide(self, request):
        decision, ahead = noticed(request.scene), request.scene.in_path_ahead(25.0)
        if not decision.analysis.immobilized or not ahead:
            return ReasonerAnswer(decision, self.name)
        plan = RecoveryPlan(behaviors=(BorrowOncomingLane(past_object_id=ahead[0].id, speed_mps=5.5),))
        return ReasonerAnswer(decision.model_copy(update={"plan": plan}), self.name)


def executed(result):
    """Names of the behaviors performed, in order."""
    found = []
    for directive in result.directives:
        if isinstance(directive, Execute) and (not found or found[-1] != directive.behavior.name):
            found.append(directive.behavior.name)
    return found


@pytest.mark.integration
@pytest.mark.parametrize("clock", ["lockstep", "latency:1.5", "latency:measured"])
def test_a_parked_car_is_passed_and_the_road_goes_on(clock):
    world = parked()
    seen = drive(world, 25.0, clock=clock)
    assert EventKind.RECOVERED in seen.kinds()
    assert executed(seen) == ["borrow_oncoming_lane"]
    assert world.x > 120.0
    assert abs(world.y) < 0.1
    assert seen.nearest_m > 0.3


@pytest.mark.integration
def test_after_the_plan_the_vehicle_is_handed_back():
    seen = drive(parked(), 25.0)
    last = max(k for k, d in enumerate(seen.directives) if isinstance(d, Execute))
    assert seen.directives[-1] is CONTINUE
    assert set(map(type, seen.directives[last + 1 :])) == {type(CONTINUE)}
    assert seen.kinds()[-2:] == [EventKind.FINISHED, EventKind.CLOSED]


def test_directive_is_same_object_while_path_is_same():
    """The same object is sent for as long as the same path is driven."""
    seen = drive(parked(), 25.0)
    assert len({id(d) for d in seen.directives if isinstance(d, Execute)}) == 1


def test_the_hand_back_comes_while_the_vehicle_still_drives():
    speeds = {}
    world = parked()
    seen = drive(world, 25.0, every_tick=lambda w: speeds.update({len(speeds): w.speed}))
    last = max(k for k, d in enumerate(seen.directives) if isinstance(d, Execute))
    assert speeds[last] > 3.0


@pytest.mark.integration
def test_oncoming_cars_are_let_pass_before_it_goes():
    cars = [thing(name, x, LANE_M, speed=-8.0) for name, x in (("first", 170.0), ("second", 230.0))]
    world = parked(*cars)
    seen = drive(world, 40.0)
    started = next(e.time_s for e in seen.events if e.kind is EventKind.STARTED)
    assert started > (230.0 - 75.0) / 8.0 - 3.0
    assert seen.nearest_m > 0.3
    assert world.x > 120.0


@pytest.mark.integration
def test_parked_car_with_two_lanes_uses_lane_change():
    """With two lanes in its direction, the ego changes there and back."""
    world = parked(road=MULTI)
    seen = drive(world, 30.0)
    assert executed(seen) == ["change_lane"]
    assert abs(world.y) < 0.1
    assert world.x > 120.0
    assert seen.nearest_m > 0.3


def test_a_red_light_is_waited_for_and_nothing_else():
    world = World(TWO_WAY, controls=(red_light(8.0),), cruise_mps=0.0)
    seen = drive(world, 20.0)
    assert set(map(type, seen.directives)) == {type(CONTINUE)}
    assert {e.decision.analysis.wait.value for e in seen.events if e.decision} == {"light"}


def cyclists():
    riders = [thing(name, x, kind=ObjectKind.BICYCLE, speed=4.0) for name, x in (("near", 75.0), ("far", 81.0))]
    return World(TWO_WAY, riders, x=40.0, sight_m=380.0)


def test_cyclists_are_followed_as_long_as_nobody_says_a_word():
    seen = drive(cyclists(), 30.0)
    assert seen.events == []
    assert set(map(type, seen.directives)) == {type(CONTINUE)}


@pytest.mark.integration
def test_asked_to_overtake_it_passes_both_cyclists():
    world = cyclists()
    seen = drive(world, 30.0, words={5.0: "please overtake the cyclists"})
    assert executed(seen) == ["borrow_oncoming_lane"]
    assert world.x > max(o.x_m for o in world.objects) + 5.0
    assert seen.nearest_m > 1.0
    assert seen.texts(EventKind.GUIDANCE_ENDED) == ['"please overtake the cyclists": done']


def test_driving_freely_costs_no_look_around():
    calls = {"surroundings": 0, "scene": 0}
    world = World(TWO_WAY, speed=8.0)

    def counted(name, make):
        def call(*seen):
            calls[name] += 1
            return make(*seen)

        return call

    surroundings = counted("surroundings", world.surroundings)
    with StuckSolver(counted("scene", world.scene), clock="lockstep") as solver:
        for _ in range(400):
            world.drive(solver.step(world.status(), surroundings))
        assert calls == {"surroundings": 0, "scene": 0}
        world.objects.append(thing("lead", world.x + 20.0))
        while calls["surroundings"] == 0:
            world.drive(solver.step(world.status(), surroundings))
        assert calls["scene"] == 1


def test_a_red_light_costs_one_look_every_few_seconds():
    world = World(TWO_WAY, controls=(red_light(8.0),), cruise_mps=0.0)
    calls = []
    original = world.scene
    world.scene = lambda surroundings: calls.append(world.time_s) or original(surroundings)
    drive(world, 31.0)
    assert 9 <= len(calls) <= 11
    assert min(b - a for a, b in itertools.pairwise(calls)) >= 3.0 - 1e-6


@pytest.mark.integration
def test_attempts_are_remembered_for_the_reasoner_until_it_is_recovered():
    """Refused because a solid line may not be crossed, until the policy says yes."""
    world = World(straight_road(oncoming=LineKind.SOLID), [thing("lead", 75.0)])
    guard = Guard(GuardPolicy(solid_line="forbid"))

    def yes_after_15_s(world):
        if world.time_s > 15.0:
            guard.policy = GuardPolicy(solid_line="autonomous")

    seen = drive(world, 40.0, reasoner=AlwaysPasses(), guard=guard, ladder=stubborn(), every_tick=yes_after_15_s)
    scenes = [e.scene for e in seen.events if e.kind is EventKind.DECIDED]
    lengths = [len(s.attempts) for s in scenes]
    assert lengths[0] == 0
    assert max(lengths) == 5
    assert "solid_line" in scenes[1].attempts[0].outcome
    assert EventKind.RECOVERED in seen.kinds()


@pytest.mark.integration
def test_after_a_recovery_the_next_episode_starts_without_memories():
    world = World(TWO_WAY, [thing("lead", 75.0), thing("second", 180.0)], sight_m=120.0)

    def clears_up(world):
        if world.time_s > 12.0:
            world.sight_m = 400.0

    seen = drive(world, 90.0, reasoner=AlwaysPasses(), every_tick=clears_up)
    decided = [e for e in seen.events if e.kind is EventKind.DECIDED]
    assert any(e.scene.attempts for e in decided)
    assert decided[-1].scene.attempts == ()
    assert world.x > 200.0


@pytest.mark.integration
def test_rejected_reasoner_gets_reason_at_once_then_cooldown():
    """A rejected reasoner is queried with the reason at once, and later only after the pause."""
    world = parked(sight_m=100.0)
    seen = drive(world, 30.0, reasoner=AlwaysPasses(), ladder=stubborn(cooldown_s=4.0))
    decided = [e for e in seen.events if e.kind is EventKind.DECIDED]
    assert decided[1].time_s - decided[0].time_s == pytest.approx(0.05)
    assert "oncoming_sight" in decided[1].scene.attempts[0].outcome


def test_plan_with_new_route_replans_at_end():
    """A plan with a new route sends `Replan` once, with the start of that route."""
    world = parked(road=MULTI)
    original = world.scene
    place = CandidateWaypoint(id="left+60", lane_id="left", x_m=60.0, y_m=LANE_M, distance_m=60.0)
    world.scene = lambda surroundings: original(surroundings).model_copy(update={"waypoints": (place,)})

    class Onwards:
        name = "onwards"

        def decide(self, request):
            answer = SearchReasoner().decide(request)
            decision = answer.decision
            if decision.plan is None:
                return answer
            plan = {"behaviors": decision.plan.behaviors[:1], "replan_route": True, "route_start": "left+60"}
            return replace(answer, decision=decision.model_copy(update={"plan": decision.plan.model_copy(update=plan)}))

    seen = drive(world, 20.0, reasoner=Onwards())
    assert [d for d in seen.directives if isinstance(d, Replan)] == [Replan(route_start="left+60")]


@pytest.mark.integration
def test_every_decision_is_told_with_its_scene_and_verdict():
    seen = drive(parked(), 25.0)
    assert seen.kinds()[:3] == [EventKind.TRIGGERED, EventKind.DECIDED, EventKind.STARTED]
    told = seen.events[1]
    assert told.trigger == "speed"
    assert told.scene.ego.stopped_for_s >= 1.0
    assert told.verdict.accepted
    assert [type(e).model_validate_json(e.model_dump_json()) for e in seen.events] == seen.events


@pytest.mark.integration
def test_the_same_world_is_driven_the_same_way_twice():
    once, again = drive(parked(), 25.0), drive(parked(), 25.0)
    assert once.directives == again.directives
    assert once.events == again.events


@pytest.mark.integration
def test_a_light_that_stays_green_lets_a_plan_pass():
    world = parked(controls=(red_light(12.0, LightState.GREEN),))
    assert EventKind.RECOVERED in drive(world, 25.0).kinds()
