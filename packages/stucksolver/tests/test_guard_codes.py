"""Every reason against a plan: provoked once, with a twin that differs in one thing and is accepted."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from stucksolver.guard import Approvals, Guard, GuardPolicy, RejectCode
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import ApprovalLevel, BorrowOncomingLane, ChangeLane, KeepLane, Wait
from stucksolver.reasoners import ReasonerAnswer
from stucksolver.scene import ControlKind, LightState, LineKind, ObjectKind, TrafficControl, Zone, ZoneKind
from stucksolver.solver import EventKind
from stucksolver.solver.state_machine.execution import Execution
from test_guard_rules import RULES
from worlds import LANE_M, World, drive, noticed, red_light, straight_road, thing

TWO_WAY = straight_road()
MULTI = straight_road(left=LineKind.BROKEN)
BORROW = BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)
LEFT = ChangeLane(side="left", distance_m=30.0, speed_mps=5.0)
AHEAD = KeepLane(distance_m=20.0, speed_mps=5.0)
AUTONOMOUS = GuardPolicy(solid_line="autonomous")


def parked(road=TWO_WAY, *others, **world):
    return World(road, [thing("lead", 65.0), *others], **world)


def codes(behavior, world, *, guided=False, policy=None):
    """Why a behavior is refused in a world; empty when it is accepted."""
    verdict, proven = Guard(policy).accept([behavior], world.view(), guided)
    assert (proven is not None) == verdict.accepted
    assert all(r.detail for r in verdict.rejects)
    return {r.code for r in verdict.rejects}


def walker(y, sideways=0.0):
    return thing("walker", 66.0, y, kind=ObjectKind.PEDESTRIAN, sideways=sideways)


def solid(**more):
    return parked(straight_road(oncoming=LineKind.SOLID), **more)


def zone(start):
    return straight_road(zones=(Zone(kind=ZoneKind.JUNCTION, start_m=start, end_m=start + 10.0),))


def sign(distance):
    return (TrafficControl(kind=ControlKind.STOP_SIGN, distance_m=distance, applies=True),)


def kerbed(line):
    return straight_road(left=line, oncoming=None)


C, K = RejectCode, ObjectKind
TWINS = {
    "stale surroundings": (C.STALE, BORROW, parked(age_s=0.6), parked(age_s=0.4)),
    "nothing of that name": (C.NO_PATH, BORROW, World(TWO_WAY, [thing("other", 65.0)]), parked()),
    "no lane to borrow": (C.NO_PATH, BORROW, parked(straight_road(oncoming=None)), parked()),
    "too near to swing out": (C.NO_PATH, BORROW, parked(x=57.5), parked(x=50.0)),
    "a lane of oncoming traffic is no lane to change to": (C.NO_PATH, LEFT, World(TWO_WAY), World(MULTI)),
    "an oncoming lane is not kept": (C.NO_PATH, AHEAD, World(TWO_WAY, y=3.0), World(TWO_WAY, y=0.5)),
    "a wall in the way": (
        C.COLLISION,
        AHEAD,
        World(TWO_WAY, [thing("wall", 62.0, kind=K.BARRIER)]),
        World(TWO_WAY, [thing("wall", 82.0, kind=K.BARRIER)]),
    ),
    "a door's width too near": (
        C.GAP,
        AHEAD,
        World(TWO_WAY, [thing("lead", 65.0, 2.0, kind=K.BARRIER)]),
        World(TWO_WAY, [thing("lead", 65.0, 2.45, kind=K.BARRIER)]),
    ),
    "a door that may open": (
        C.DOOR,
        AHEAD,
        World(TWO_WAY, [thing("lead", 65.0, 2.7)]),
        World(TWO_WAY, [thing("lead", 65.0, 2.8)]),
    ),
    "a door of one who has only just stopped": (
        C.DOOR,
        AHEAD,
        World(TWO_WAY, [thing("lead", 65.0, 2.7)]),
        World(TWO_WAY, [thing("lead", 65.0, 2.7, stationary_s=1.0)]),
    ),
    "a door at walking pace": (
        C.DOOR,
        AHEAD,
        World(TWO_WAY, [thing("lead", 65.0, 2.45)]),
        World(TWO_WAY, [thing("lead", 65.0, 2.45, kind=K.BUS)]),
    ),
    "a walker who may step off the kerb": (
        C.CLEARANCE,
        AHEAD,
        World(TWO_WAY, [walker(-2.5)]),
        World(TWO_WAY, [walker(-2.75)]),
    ),
    "a walker steps out": (
        C.COLLISION,
        KeepLane(distance_m=40.0, speed_mps=5.0),
        World(TWO_WAY, [walker(-6.0, 1.0)]),
        World(TWO_WAY, [walker(-6.0, -1.0)]),
    ),
    "a red light": (
        C.RED_LIGHT,
        AHEAD,
        World(TWO_WAY, controls=(red_light(10.0),)),
        World(TWO_WAY, controls=(red_light(10.0, LightState.GREEN),)),
    ),
    "a bumper over the line of a red light": (
        C.RED_LIGHT,
        AHEAD,
        World(TWO_WAY, controls=(red_light(-0.5),)),
        World(TWO_WAY, controls=(red_light(-5.0),)),
    ),
    "a light whose state is not seen": (
        C.RED_LIGHT,
        AHEAD,
        World(TWO_WAY, controls=(red_light(10.0, LightState.UNKNOWN),)),
        World(TWO_WAY, controls=(red_light(30.0, LightState.UNKNOWN),)),
    ),
    "a stop line": (C.STOP_LINE, AHEAD, World(TWO_WAY, controls=sign(10.0)), World(TWO_WAY, controls=sign(30.0))),
    "too little sight": (C.ONCOMING_SIGHT, BORROW, parked(sight_m=100.0), parked(sight_m=300.0)),
    "an oncoming car": (
        C.ONCOMING_GAP,
        BORROW,
        parked(TWO_WAY, thing("car", 150.0, LANE_M, speed=-10.0)),
        parked(TWO_WAY, thing("car", 290.0, LANE_M, speed=-10.0)),
    ),
    "a car from behind in the lane beside": (
        C.LANE_ENTRY,
        LEFT,
        World(MULTI, [thing("car", 30.0, LANE_M, speed=12.0)]),
        World(MULTI, [thing("car", 30.0, LANE_M, speed=3.0)]),
    ),
    "a body already over the line": (
        C.LANE_ENTRY,
        LEFT,
        World(MULTI, [thing("car", 30.0, LANE_M, speed=12.0)], y=1.0),
        World(MULTI, [thing("car", -20.0, LANE_M, speed=12.0)], y=1.0),
    ),
    "somebody behind passes already": (
        C.LANE_ENTRY,
        BORROW,
        parked(TWO_WAY, thing("car", 35.0, LANE_M, speed=10.0)),
        parked(TWO_WAY, thing("car", 35.0, 0.0, speed=0.4)),
    ),
    "a junction": (C.ZONE, BORROW, parked(zone(70.0)), parked(zone(100.0))),
    "a solid line without anybody's yes": (C.SOLID_LINE, BORROW, solid(), parked()),
    "a kerb": (C.OFF_ROAD, LEFT, World(kerbed(LineKind.KERB)), World(kerbed(LineKind.BROKEN))),
    "beyond the known road": (C.OFF_ROAD, AHEAD, World(TWO_WAY, x=385.0), World(TWO_WAY, x=370.0)),
    "on beside the road": (C.OFF_LANES, AHEAD, World(TWO_WAY, y=-2.5), World(TWO_WAY, y=-1.2)),
    "an unasked speed": (
        C.OVERSPEED,
        KeepLane(distance_m=20.0, speed_mps=6.0),
        World(TWO_WAY),
        None,
    ),
}


@pytest.mark.parametrize(("code", "behavior", "refused", "accepted"), TWINS.values(), ids=TWINS)
def test_it_is_refused_for_that_and_accepted_without(code, behavior, refused, accepted):
    assert code in codes(behavior, refused)
    if accepted is not None:
        assert codes(behavior, accepted) == set()


def test_a_passenger_may_ask_for_more_speed():
    assert codes(KeepLane(distance_m=20.0, speed_mps=11.0), World(TWO_WAY), guided=True) == set()
    assert codes(KeepLane(distance_m=20.0, speed_mps=6.0), World(TWO_WAY)) == {RejectCode.OVERSPEED}


def test_solid_line_crossing_needs_policy_and_stationary_obstacle():
    """A solid line is crossed only if the policy permits it, and only past a stationary obstacle."""
    assert codes(BORROW, solid(), policy=AUTONOMOUS) == set()
    just = World(straight_road(oncoming=LineKind.SOLID), [thing("lead", 65.0, stationary_s=1.0)])
    assert codes(BORROW, just, policy=AUTONOMOUS) == {RejectCode.SOLID_LINE, RejectCode.WAIT_FIRST}


def test_a_solid_line_is_not_crossed_for_nothing():
    empty = World(straight_road(left=LineKind.SOLID, oncoming=None))
    there_and_back = [LEFT, ChangeLane(side="right", distance_m=25.0, speed_mps=5.0)]
    verdict, _ = Guard(AUTONOMOUS).accept(there_and_back, empty.view(), guided=False)
    assert {r.code for r in verdict.rejects} == {RejectCode.SOLID_LINE}
    assert Guard(AUTONOMOUS).accept(there_and_back[1:], replace(empty, y=LANE_M).view(), guided=False)[0].accepted


def test_a_kerb_is_never_crossed_whatever_the_policy():
    assert codes(LEFT, World(kerbed(LineKind.KERB)), policy=AUTONOMOUS) == {RejectCode.OFF_ROAD}


def test_standing_in_an_oncoming_lane_is_against_its_precondition():
    guard, wait = Guard(), Wait(duration_s=3.0)
    assert [r.code for r in guard.allows_standing(wait, World(TWO_WAY, y=3.0).view()).rejects] == [C.PRECONDITION]
    assert guard.allows_standing(wait, World(TWO_WAY).view()).accepted
    assert [r.code for r in guard.allows_standing(wait, World(TWO_WAY, age_s=1.0).view()).rejects] == [C.STALE]


def test_a_vehicle_beside_its_path_has_left_what_was_proven():
    guard = Guard()
    _, proven = guard.accept([AHEAD], World(TWO_WAY).view(), guided=False)
    assert guard.recheck(proven, World(TWO_WAY, x=55.0, y=0.5).view()).accepted
    verdict = guard.recheck(proven, World(TWO_WAY, x=55.0, y=-1.0).view())
    assert [r.code for r in verdict.rejects] == [C.DEVIATION]


def test_a_plan_that_takes_too_long_times_out():
    world = World(TWO_WAY)
    execution = Execution(RecoveryPlan(behaviors=(AHEAD,)), Guard(), guided=False)
    assert execution.start(world.view(), 0.0).accepted
    execution.tick(world.view(), 1.0)
    assert execution.last_verdict.accepted
    execution.tick(world.view(), 100.0)
    assert [r.code for r in execution.last_verdict.rejects] == [C.TIMEOUT]


class AlwaysBorrow:
    """Answers with the same plan to everything."""

    name = "always"

    def decide(self, request):
        plan = RecoveryPlan(behaviors=(BORROW,))
        return ReasonerAnswer(noticed(request.scene).model_copy(update={"plan": plan}), self.name)


@pytest.mark.parametrize("words", [{}, {5.0: "overtake"}])
def test_lead_moves_again_pass_needs_guidance(words):
    """A plan to pass a lead that moves again is not started without guidance.

    The lead sets off while the reasoner answers; with a passenger's guidance, the plan is checked.
    """
    world = World(TWO_WAY, [thing("lead", 64.0, speed=0.0)], cruise_mps=8.0)

    def leader_goes_on(world):
        if world.time_s > 5.5:
            world.objects = [world.objects[0].model_copy(update={"vx_mps": 3.0})]

    seen = drive(world, 9.0, reasoner=AlwaysBorrow(), clock="latency:3", every_tick=leader_goes_on, words=words)
    judged = [e for e in seen.events if e.verdict]
    assert bool(judged) == bool(words)
    assert words or EventKind.STARTED not in seen.kinds()


def test_every_code_has_its_test():
    elsewhere = set(RULES) | {
        C.APPROVAL,
        C.NO_ABORT,
        C.PRECONDITION,
        C.DEVIATION,
        C.TIMEOUT,
        C.NOT_IMMOBILIZED,
        C.REPEATED,
        C.IMPLAUSIBLE,
    }
    assert {case[0] for case in TWINS.values()} | elsewhere == set(RejectCode)


def test_a_verdict_reads_as_its_reasons():
    verdict, _ = Guard().accept([BORROW], parked(sight_m=100.0).view(), guided=False)
    assert "oncoming_sight: oncoming lane: sight distance 100.0 m" in str(verdict)
    assert str(Guard().accept([BORROW], parked().view(), guided=False)[0]) == "accepted"
    assert math.isfinite(verdict.rejects[0].gap_m)


def test_what_needs_a_persons_yes_is_refused_without_it():
    policy = GuardPolicy(releases={"keep_lane": ApprovalLevel.PASSENGER})
    assert codes(AHEAD, World(TWO_WAY), policy=policy) == {C.APPROVAL}
    guard, view = Guard(policy), World(TWO_WAY).view()
    assert guard.accept([AHEAD], view, False, Approvals(passenger=frozenset({"keep_lane"})))[0].accepted
    assert guard.accept([AHEAD], view, False, Approvals(operator=frozenset({"keep_lane"})))[0].accepted
    strict = Guard(GuardPolicy(releases={"keep_lane": ApprovalLevel.OPERATOR}))
    assert not strict.accept([AHEAD], view, False, Approvals(passenger=frozenset({"keep_lane"})))[0].accepted


def test_a_solid_line_needs_the_passengers_yes_by_default():
    yes = Approvals(passenger=frozenset({"solid_line"}))
    assert Guard().accept([BORROW], solid().view(), False, yes)[0].accepted


def test_a_policy_for_an_unknown_behavior_is_refused_by_name():
    with pytest.raises(ValueError, match="'fly'"):
        GuardPolicy(releases={"fly": ApprovalLevel.AUTONOMOUS})
