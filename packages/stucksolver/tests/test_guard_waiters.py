"""Queues of vehicles of any kind, emergency vehicles with lights off or unknown, and rails as the end of a plan."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grids import sample
from stucksolver.guard import Approvals, Guard, GuardPolicy, RejectCode
from stucksolver.plan.behaviors import BackUp, BorrowOncomingLane, ChangeLane, Creep, FollowVehicle, KeepLane
from stucksolver.scene import LineKind, ObjectKind, Zone, ZoneKind
from worlds import World, straight_road, thing

GUARD = Guard()
K, C = ObjectKind, RejectCode
ROAD, MULTI = straight_road(), straight_road(left=LineKind.BROKEN)
PAST = BorrowOncomingLane(past_object_id="last", speed_mps=5.0)
OPERATOR = Approvals(operator=frozenset({"level_crossing"}))


def codes(world, *behaviors, guided=False, guard=GUARD, approvals=None):
    return set(guard.accept(behaviors, world.view(), guided, approvals or Approvals())[0].codes)


# ---- queues

QUEUEING = [K.CAR, K.VAN, K.TRUCK, K.BUS, K.MOTORCYCLE, K.BICYCLE, K.UNKNOWN]


def sized(kind):
    """Boxes as perception gives them."""
    return {K.MOTORCYCLE: {"length": 2.1, "width": 0.8}, K.TRUCK: {"length": 8.0, "width": 2.4}}.get(kind, {})


@pytest.mark.parametrize(("first", "last", "guided"), sample(itertools.product(QUEUEING, QUEUEING, [False, True]), 20))
def test_queue_of_vehicles_of_any_kind_is_not_passed(first, last, guided):
    row = [thing("last", 66.0, kind=last, **sized(last)), thing("first", 75.0, kind=first, **sized(first))]
    assert C.WAIT_FIRST in codes(World(ROAD, row, sight_m=400.0), PAST, guided=guided)


@given(
    kinds=st.lists(st.sampled_from(QUEUEING), min_size=2, max_size=4),
    gap_m=st.floats(0.8, 9.0),
    aside=st.lists(st.floats(-0.35, 0.35), min_size=4, max_size=4),
    stood_s=st.floats(10.0, 900.0),
    guided=st.booleans(),
    claims=st.sampled_from([Approvals(), Approvals(passenger=frozenset({"long_stay"}))]),
)
@settings(max_examples=40)
def test_queue_is_not_passed_however_long_it_stands(kinds, gap_m, aside, stood_s, guided, claims):
    row, x = [], 62.0
    for k, kind in enumerate(kinds):
        one = thing("last" if k == 0 else f"n{k}", 0.0, aside[k], kind=kind, stationary_s=stood_s, **sized(kind))
        row.append(one.model_copy(update={"x_m": x + one.length_m / 2}))
        x += one.length_m + gap_m
    assert C.WAIT_FIRST in codes(World(ROAD, row, sight_m=400.0), PAST, guided=guided, approvals=claims)


@pytest.mark.parametrize("y", [-1.3, -0.9, 0.0, 0.9])
def test_queue_of_bicycles_at_side_of_lane_is_not_passed(y):
    """Bicycles that wait at the side of the lane are a queue."""
    row = [thing("last", 64.0, y, kind=K.BICYCLE), thing("first", 67.5, y, kind=K.BICYCLE)]
    assert C.WAIT_FIRST in codes(World(ROAD, row, sight_m=400.0), PAST)


@pytest.mark.parametrize("creeps_mps", [0.15, 0.3, 0.45])
@pytest.mark.parametrize("guided", [False, True])
def test_queue_that_creeps_on_is_a_queue(creeps_mps, guided):
    row = [thing("last", 66.0, speed=creeps_mps), thing("first", 74.0, speed=creeps_mps)]
    assert C.WAIT_FIRST in codes(World(ROAD, row, sight_m=400.0), PAST, guided=guided)


def test_no_solid_line_is_crossed_past_bicycles_that_queue():
    guard = Guard(GuardPolicy(solid_line="autonomous"))
    row = [thing("last", 64.0, kind=K.BICYCLE), thing("first", 67.5, kind=K.BICYCLE)]
    road = straight_road(oncoming=LineKind.SOLID)
    assert C.SOLID_LINE in codes(World(road, row, sight_m=400.0), PAST, guard=guard)


@pytest.mark.parametrize("kind", [K.UNKNOWN, K.BICYCLE, K.CAR])
def test_single_vehicle_that_stands_long_is_passed(kind):
    assert C.WAIT_FIRST not in codes(World(ROAD, [thing("last", 66.0, kind=kind)], sight_m=400.0), PAST)


def test_small_unknown_thing_before_a_car_makes_no_queue():
    row = [thing("last", 66.0), thing("box", 72.0, kind=K.UNKNOWN, length=0.6, width=0.6)]
    assert C.WAIT_FIRST not in codes(World(ROAD, row, sight_m=400.0), PAST)


# ---- emergency vehicles


def ambulance(lights, **more):
    return thing("last", 66.0, more.pop("y", 0.0), kind=K.EMERGENCY, emergency_lights=lights, **more)


@pytest.mark.parametrize("lights", [True, None])
@pytest.mark.parametrize("guided", [False, True])
@pytest.mark.parametrize("hazard", [False, True, None])
def test_emergency_vehicle_with_lights_on_or_unknown_is_a_scene(lights, guided, hazard):
    world = World(ROAD, [ambulance(lights, hazard=hazard)], sight_m=400.0)
    assert C.AUTHORITY in codes(world, PAST, guided=guided)
    approved = Approvals(operator=frozenset({"emergency_scene"}))
    assert C.AUTHORITY not in codes(world, PAST, guided=guided, approvals=approved)


@pytest.mark.parametrize("lights", [True, None])
def test_emergency_scene_is_passed_by_a_whole_lane(lights):
    world = World(MULTI, [ambulance(lights)], sight_m=400.0)
    assert C.AUTHORITY not in codes(world, ChangeLane(side="left", distance_m=50.0, speed_mps=5.0))


@pytest.mark.parametrize("more", [{}, {"hazard": True}, {"y": -0.8}])
@pytest.mark.parametrize("guided", [False, True])
@pytest.mark.parametrize("claims", [Approvals(), Approvals(passenger=frozenset({"long_stay"}))])
def test_dark_emergency_vehicle_is_passed_only_after_the_long_wait(more, guided, claims):
    """Its crew may come back at any moment: parked, hazard lights and words do not shorten the wait."""
    for stood_s, waits in ((3.5, True), (9.0, True), (10.5, False)):
        world = World(ROAD, [ambulance(False, stationary_s=stood_s, **more)], sight_m=400.0)
        found = codes(world, PAST, guided=guided, approvals=claims)
        assert (C.WAIT_FIRST in found) is waits
        assert C.AUTHORITY not in found


# ---- rails


def railed(start_m, end_m, kind=ZoneKind.LEVEL_CROSSING, road=straight_road):
    return road(zones=(Zone(kind=kind, start_m=start_m, end_m=end_m),))


def end_of(world, plan, approvals=OPERATOR):
    verdict, proven = GUARD.accept([plan], world.view(), True, approvals)
    return verdict, None if proven is None else proven.path


MOVES = st.one_of(
    st.builds(KeepLane, distance_m=st.floats(1.0, 60.0), speed_mps=st.floats(0.6, 5.5)),
    st.builds(Creep, distance_m=st.floats(1.0, 15.0), speed_mps=st.floats(0.6, 2.2)),
    st.builds(FollowVehicle, leader_id=st.just("lead"), distance_m=st.floats(5.0, 60.0), speed_mps=st.floats(0.6, 5.5)),
    st.builds(BackUp, distance_m=st.floats(1.0, 40.0)),
)


@given(plan=MOVES, start_m=st.floats(30.0, 90.0), length_m=st.floats(2.0, 12.0), approved=st.booleans())
@settings(max_examples=60)
def test_no_accepted_plan_ends_on_rails(plan, start_m, length_m, approved):
    world = World(railed(start_m, start_m + length_m), [thing("lead", 140.0, speed=3.0)])
    _, path = end_of(world, plan, OPERATOR if approved else Approvals())
    if path is None:
        return
    end = -path.end_s if plan.reverse else path.end_s
    assert end + 4.9 / 2 <= start_m or end - 4.9 / 2 >= start_m + length_m


@pytest.mark.parametrize("distance_m", [20.0, 24.0, 28.0])
def test_plan_ending_on_rails_is_rejected_despite_approval(distance_m):
    """A plan that ends on rails is rejected even if the level crossing is approved."""
    world = World(railed(70.0, 78.0))
    assert C.STOPPING_PLACE in codes(world, KeepLane(distance_m=distance_m, speed_mps=5.5), approvals=OPERATOR)


def test_plan_that_hands_over_on_rails_is_refused():
    """The stack takes over before the end of the path: there no part of the body is on the rails either."""
    world = World(railed(70.0, 78.0))
    for distance_m, refused in ((32.0, True), (36.0, True), (48.0, False)):
        found = codes(world, KeepLane(distance_m=distance_m, speed_mps=5.5), approvals=OPERATOR)
        assert (C.STOPPING_PLACE in found) is refused, distance_m


@pytest.mark.parametrize("x", [70.0, 72.0, 76.0])
def test_leaving_rails_stays_allowed(x):
    world = World(railed(70.0, 76.0), x=x)
    assert codes(world, KeepLane(distance_m=15.0, speed_mps=3.0)) == set()
    assert codes(world, BackUp(distance_m=8.0)) <= ({C.STOPPING_PLACE, C.AUTHORITY} if x > 74.0 else set())


def test_moving_on_rails_without_leaving_them_is_refused():
    world = World(railed(60.0, 90.0), x=70.0)
    assert C.STOPPING_PLACE in codes(world, KeepLane(distance_m=6.0, speed_mps=2.0), approvals=OPERATOR)


def test_lane_change_that_ends_on_rails_is_refused():
    world = World(railed(84.0, 92.0, road=lambda zones: straight_road(left=LineKind.BROKEN, zones=zones)))
    plan = ChangeLane(side="left", distance_m=38.0, speed_mps=5.0)
    assert C.STOPPING_PLACE in codes(world, plan, approvals=OPERATOR)
