"""The rules of the road that someone will be tempted to bend: each refused once, with a twin that is accepted."""

from __future__ import annotations

import pytest

from stucksolver.guard import Approvals, Guard, GuardPolicy, RejectCode
from stucksolver.guard.policy import SpeedPolicy
from stucksolver.plan.behaviors import (
    ApprovalLevel,
    BackUp,
    BorrowOncomingLane,
    ChangeLane,
    Creep,
    DriveOver,
    FollowVehicle,
    KeepLane,
    Nudge,
    PullOver,
    RejoinRoute,
    RequestAssistance,
    Wait,
)
from stucksolver.scene import ControlKind, LightState, LineKind, ObjectKind, TrafficControl, Zone, ZoneKind
from worlds import LANE_M, World, red_light, straight_road, thing

TWO_WAY = straight_road()
MULTI = straight_road(left=LineKind.BROKEN, oncoming=None)
BORROW = BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)
AHEAD = KeepLane(distance_m=20.0, speed_mps=5.0)
OVER = DriveOver(object_id="bag")
C, K = RejectCode, ObjectKind


def codes(behavior, world, *, guided=False, policy=None, approvals=None):
    verdict, proven = Guard(policy).accept([behavior], world.view(), guided, approvals or Approvals())
    assert (proven is not None) == verdict.accepted
    return {r.code for r in verdict.rejects}


def lead(**more):
    return World(TWO_WAY, [thing("lead", 65.0, **more)])


def bag(*others, **more):
    usual = {"kind": K.BAG, "height": 0.1, "seen_for_s": 2.0, "kind_confidence": 0.95}
    return World(TWO_WAY, [thing("bag", 60.0, **{**usual, **more}), *others])


def zoned(kind, start, end):
    return straight_road(zones=(Zone(kind=kind, start_m=start, end_m=end),))


def walker(x, y, kind=K.PEDESTRIAN):
    return thing("walker", x, y, kind=kind)


def narrowing(width):
    """The own lane is narrower from 55 m to 57 m."""
    own = TWO_WAY.lanes[0]
    widths = tuple(width if 55 <= x <= 57 else w for x, w in enumerate(own.width_m))
    return TWO_WAY.model_copy(
        update={"key": f"narrow-{width}", "lanes": (own.model_copy(update={"width_m": widths}), TWO_WAY.lanes[1])}
    )


def next_to_light(distance):
    world = lead()
    world.controls = (red_light(distance),)
    return world


GOOD_BAG = bag()
TWINS = {
    "a queue is never passed": (C.WAIT_FIRST, BORROW, lead(moved_s_ago=30.0), lead(moved_s_ago=61.0)),
    "one who waits at a light is a queue": (C.WAIT_FIRST, BORROW, next_to_light(20.0), lead()),
    "a vehicle is given its time": (C.WAIT_FIRST, BORROW, lead(stationary_s=9.0), lead(stationary_s=11.0)),
    "with hazard lights three seconds": (
        C.WAIT_FIRST,
        BORROW,
        lead(stationary_s=2.0, hazard=True),
        lead(stationary_s=4.0, hazard=True),
    ),
    "parked three seconds": (C.WAIT_FIRST, BORROW, lead(stationary_s=4.0), lead(stationary_s=4.0, y=-0.6)),
    "not tracked is no standing": (C.WAIT_FIRST, BORROW, lead(stationary_s=0.0), lead()),
    "only what is soft is driven over": (C.NOT_PASSABLE, OVER, bag(kind=K.DEBRIS), GOOD_BAG),
    "never an unknown": (C.NOT_PASSABLE, OVER, bag(kind=K.UNKNOWN), GOOD_BAG),
    "never an animal": (C.NOT_PASSABLE, OVER, bag(kind=K.ANIMAL), GOOD_BAG),
    "not what is high": (C.NOT_PASSABLE, OVER, bag(height=0.16), bag(height=0.15)),
    "not on doubt": (C.NOT_PASSABLE, OVER, bag(kind_confidence=0.7), bag(kind_confidence=0.8)),
    "not without a stated confidence": (C.NOT_PASSABLE, OVER, bag(kind_confidence=None), GOOD_BAG),
    "not at first sight": (C.NOT_PASSABLE, OVER, bag(seen_for_s=0.9), bag(seen_for_s=1.0)),
    "not with somebody beside it": (C.NOT_PASSABLE, OVER, bag(walker(60.0, -2.3)), bag(walker(60.0, -2.5))),
    "not with an unknown beside it": (C.NOT_PASSABLE, OVER, bag(walker(60.0, -2.3, K.UNKNOWN)), GOOD_BAG),
    "an emergency scene": (
        C.AUTHORITY,
        AHEAD,
        World(TWO_WAY, [thing("van", 65.0, -2.4, kind=K.EMERGENCY, emergency_lights=True)]),
        World(TWO_WAY, [thing("van", 65.0, -5.0, kind=K.EMERGENCY, emergency_lights=True)]),
    ),
    "an emergency scene half in the way": (
        C.AUTHORITY,
        KeepLane(distance_m=20.0, speed_mps=2.0),
        World(TWO_WAY, [thing("van", 65.0, -2.4, kind=K.EMERGENCY, emergency_lights=True)]),
        World(TWO_WAY, [thing("van", 65.0, -2.4, kind=K.EMERGENCY, emergency_lights=False)]),
    ),
    "an emergency scene through the oncoming lane": (
        C.AUTHORITY,
        BORROW,
        lead(kind=K.EMERGENCY, emergency_lights=True),
        lead(kind=K.EMERGENCY, emergency_lights=False),
    ),
    "a school bus that stands": (
        C.AUTHORITY,
        AHEAD,
        World(TWO_WAY, [thing("bus", 65.0, LANE_M, kind=K.SCHOOL_BUS)]),
        World(TWO_WAY, [thing("bus", 95.0, LANE_M, kind=K.SCHOOL_BUS)]),
    ),
    "a flagger": (C.AUTHORITY, AHEAD, World(TWO_WAY, [walker(65.0, -4.0, K.FLAGGER)]), World(TWO_WAY)),
    "a crossing gate": (
        C.AUTHORITY,
        AHEAD,
        World(TWO_WAY, [thing("gate", 65.0, -4.0, kind=K.CROSSING_GATE)]),
        World(TWO_WAY, [thing("gate", 85.0, -4.0, kind=K.CROSSING_GATE)]),
    ),
    "a level crossing": (
        C.AUTHORITY,
        AHEAD,
        World(zoned(ZoneKind.LEVEL_CROSSING, 60.0, 65.0)),
        World(zoned(ZoneKind.LEVEL_CROSSING, 80.0, 85.0)),
    ),
    "creeping into a crosswalk": (
        C.STOPPING_PLACE,
        Creep(distance_m=8.0),
        World(zoned(ZoneKind.CROSSWALK, 58.0, 62.0)),
        World(zoned(ZoneKind.CROSSWALK, 61.0, 65.0)),
    ),
    "backing into a junction": (
        C.STOPPING_PLACE,
        BackUp(distance_m=5.0),
        World(zoned(ZoneKind.JUNCTION, 30.0, 43.0)),
        World(zoned(ZoneKind.JUNCTION, 30.0, 42.0)),
    ),
    "a nudge out of the lane": (
        C.LEAVES_LANE,
        Nudge(side="left", offset_m=0.8, distance_m=12.0),
        World(narrowing(2.3)),
        World(TWO_WAY),
    ),
    "backing up unseen": (C.PATH_NOT_VISIBLE, BackUp(distance_m=8.0), World(TWO_WAY, behind_m=10.0), World(TWO_WAY)),
    "too long beside the route": (
        C.OFF_ROUTE,
        ChangeLane(side="left", distance_m=150.0, speed_mps=2.0),
        World(MULTI),
        None,
    ),
}
RULES = {case[0] for case in TWINS.values()}


@pytest.mark.parametrize(("code", "behavior", "refused", "accepted"), TWINS.values(), ids=TWINS)
def test_it_is_refused_for_that_and_accepted_without(code, behavior, refused, accepted):
    assert code in codes(behavior, refused)
    if accepted is not None:
        assert codes(behavior, accepted) == set()


@pytest.mark.parametrize("kind", [k for k in ObjectKind if k not in (K.BAG, K.LITTER)])
def test_nobodys_yes_makes_another_kind_passable(kind):
    yes = Approvals(passenger=frozenset({"drive_over"}), operator=frozenset({"drive_over"}))
    assert C.NOT_PASSABLE in codes(OVER, bag(kind=kind), approvals=yes)


def test_a_passenger_may_confirm_a_bag_but_not_conjure_one():
    yes = Approvals(passenger=frozenset({"drive_over"}))
    assert codes(OVER, bag(kind_confidence=0.6)) == {C.NOT_PASSABLE}
    assert codes(OVER, bag(kind_confidence=0.6), approvals=yes) == set()
    assert codes(OVER, bag(kind_confidence=0.4), approvals=yes) == {C.NOT_PASSABLE}


def test_emergency_scene_is_passed_in_whole_adjacent_lane():
    """The ego passes an emergency scene only if a whole lane is free beside it."""
    over = ChangeLane(side="left", distance_m=40.0, speed_mps=5.0)
    police = thing("police", 65.0, kind=K.EMERGENCY, emergency_lights=True)
    astride = thing("police", 65.0, 1.2, kind=K.EMERGENCY, emergency_lights=True)
    assert codes(over, World(MULTI, [police])) == set()
    assert C.AUTHORITY in codes(over, World(MULTI, [astride]))


def test_policy_releases_only_emergency_scenes():
    """The policy may permit emergency scenes, and permits nothing else with them."""
    policy = GuardPolicy(emergency_scene=ApprovalLevel.AUTONOMOUS)
    assert codes(BORROW, lead(kind=K.EMERGENCY, emergency_lights=True), policy=policy) == set()
    assert codes(BORROW, lead(kind=K.SCHOOL_BUS), policy=policy) == {C.AUTHORITY}


@pytest.mark.parametrize("rule", ["emergency_scene", "school_bus"])
def test_an_operator_releases_one_scene_and_not_another(rule):
    kind = {"emergency_scene": K.EMERGENCY, "school_bus": K.SCHOOL_BUS}[rule]
    world = World(TWO_WAY, [thing("it", 65.0, -2.4, kind=kind, emergency_lights=True)])
    slow = KeepLane(distance_m=20.0, speed_mps=2.0)
    assert codes(slow, world, approvals=Approvals(passenger=frozenset({rule}))) == {C.AUTHORITY}
    assert codes(slow, world, approvals=Approvals(operator=frozenset({"flagger"}))) == {C.AUTHORITY}
    assert codes(slow, world, approvals=Approvals(operator=frozenset({rule}))) == set()


def test_red_light_needs_operator_approval_and_creeping():
    """A red light is passed only with an operator's approval, and only at a creep."""
    world = World(TWO_WAY, controls=(red_light(4.0),))
    slow, quick = KeepLane(distance_m=20.0, speed_mps=2.0), AHEAD
    operator = Approvals(operator=frozenset({"red_light"}))
    assert codes(slow, world) == {C.RED_LIGHT}
    assert codes(slow, world, guided=True, approvals=Approvals(passenger=frozenset({"red_light"}))) == {C.RED_LIGHT}
    assert codes(quick, world, approvals=operator) == {C.RED_LIGHT}
    assert codes(slow, world, approvals=operator) == set()


@pytest.mark.parametrize("kind", [ControlKind.TRAFFIC_LIGHT, ControlKind.STOP_SIGN])
def test_dark_light_or_stop_sign_is_passed_creeping_after_stop(kind):
    state = LightState.OFF if kind is ControlKind.TRAFFIC_LIGHT else None
    slow, quick = KeepLane(distance_m=20.0, speed_mps=2.0), AHEAD

    def at(distance, **world):
        control = TrafficControl(kind=kind, distance_m=distance, applies=True, state=state)
        return World(TWO_WAY, controls=(control,), **world)

    assert codes(slow, at(4.0)) == set()
    assert codes(quick, at(4.0)) == {C.STOP_LINE}
    assert codes(slow, at(10.0)) == {C.STOP_LINE}
    assert codes(slow, at(4.0, speed=2.0)) == {C.STOP_LINE}


def test_at_a_dark_light_crossing_traffic_goes_first():
    world = World(TWO_WAY, controls=(red_light(4.0, LightState.OFF),))
    world.objects = [thing("car", 62.0, -25.0, sideways=5.0, yaw=1.57)]
    assert C.COLLISION in codes(KeepLane(distance_m=20.0, speed_mps=2.0), world)


def test_a_moving_leader_is_passed_only_when_a_passenger_asks():
    world = World(TWO_WAY, [thing("lead", 62.0, kind=K.BICYCLE, speed=2.0)])
    fast = BorrowOncomingLane(past_object_id="lead", speed_mps=5.5)
    assert C.WAIT_FIRST in codes(fast, world)
    assert C.WAIT_FIRST not in codes(fast, world, guided=True)


def test_no_passengers_words_make_a_queue_an_obstruction():
    assert codes(BORROW, lead(moved_s_ago=20.0), guided=True) == {C.WAIT_FIRST}


@pytest.mark.parametrize("behavior", [Creep(distance_m=8.0), BackUp(distance_m=5.0), OVER], ids=lambda b: b.name)
def test_what_must_be_slow_is_slow(behavior):
    policy = GuardPolicy(speeds=SpeedPolicy(creep_mps=0.4))
    assert C.OVERSPEED in codes(behavior, GOOD_BAG, policy=policy) or behavior.name == "creep"


def test_accept_stop_in_path_of_crossing_car_is_rejected():
    """A crossing car that a stop would meet leaves no safe abort.

    It passes behind the ego if the ego goes on, and would hit the ego at a stop.
    """
    found = set()
    for y in (-40.0, -32.0, -28.0, -24.0, -20.0, -16.0):
        world = World(TWO_WAY, [thing("car", 66.0, y, sideways=6.0, yaw=1.57)], speed=5.0)
        found |= codes(KeepLane(distance_m=40.0, speed_mps=5.0), world)
    assert found & {C.COLLISION, C.NO_ABORT, C.GAP}


def test_allows_standing_on_rails_or_in_oncoming_lane_is_rejected():
    """A wait on a level crossing or in an oncoming lane is rejected."""
    guard = Guard()
    for behavior in (Wait(duration_s=3.0), RequestAssistance(reason="blocked")):
        crossing = World(zoned(ZoneKind.LEVEL_CROSSING, 48.0, 52.0))
        assert [r.code for r in guard.allows_standing(behavior, crossing.view()).rejects] == [C.PRECONDITION]
        assert [r.code for r in guard.allows_standing(behavior, World(TWO_WAY, y=3.0).view()).rejects] == [
            C.PRECONDITION
        ]
        assert guard.allows_standing(behavior, World(TWO_WAY).view()).accepted


def test_back_up_to_stopped_car_needs_less_sight():
    """Where a stopped car fills the lane behind, less of that lane needs to be visible."""

    def behind(y, kind=K.CAR, speed=0.0):
        # The car's front is 4.9 m behind our bumper.
        return World(TWO_WAY, [thing("behind", 50.0 - 2.45 - 4.9 - 2.3, y, kind=kind, speed=speed)], behind_m=7.35)

    back = BackUp(distance_m=2.0)
    assert codes(back, behind(0.0)) == set()
    assert C.PATH_NOT_VISIBLE in codes(back, behind(1.8))
    assert C.PATH_NOT_VISIBLE in codes(back, behind(0.0, kind=K.PEDESTRIAN))
    assert codes(BackUp(distance_m=4.0), behind(0.0)) != set()
    assert codes(back, behind(0.0, speed=1.0)) != set()


def test_backing_up_is_refused_with_somebody_behind():
    near = World(TWO_WAY, [thing("behind", 41.0)])
    coming = World(TWO_WAY, [thing("behind", 20.0, speed=4.0)])
    assert C.COLLISION in codes(BackUp(distance_m=5.0), near)
    assert codes(BackUp(distance_m=5.0), coming) & {C.COLLISION, C.GAP}
    assert codes(BackUp(distance_m=5.0), World(TWO_WAY, [thing("ahead", 58.0)])) == set()


def test_following_needs_a_leader_that_leads():
    follow = FollowVehicle(leader_id="lead", distance_m=40.0, speed_mps=5.0)
    assert codes(follow, World(TWO_WAY, [thing("lead", 65.0, speed=4.0)])) == set()
    assert codes(follow, lead()) == {C.NO_PATH}
    assert codes(follow, World(TWO_WAY)) == {C.NO_PATH}


def test_rejoining_leads_back_to_the_routes_lane():
    world = World(MULTI, y=LANE_M)
    verdict, proven = Guard().accept([RejoinRoute()], world.view(), False)
    assert proven is not None, str(verdict)
    assert abs(proven.path.end_d) < 0.05


def test_pulling_over_ends_at_the_right_edge():
    verdict, proven = Guard().accept([PullOver()], World(TWO_WAY).view(), False)
    assert proven is not None, str(verdict)
    assert proven.path.end_d == pytest.approx(-1.75 + 1.85 / 2 + 0.2, abs=0.06)
    assert proven.path.stops
