"""Passes, returns and turned starts for which no recipe of shifts has a path: the searched ones, through the guard."""

from __future__ import annotations

import math

import numpy as np
import pytest

from grids import each_value
from stucksolver.guard import NOBODY, Guard
from stucksolver.plan.behaviors import (
    BehaviorStart,
    BorrowOncomingLane,
    ChangeLane,
    KeepLane,
    NoPathError,
    Nudge,
    RejoinRoute,
    behavior,
)
from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.plan.object_gaps import bounded_speed, gaps, lack_toward_objects
from stucksolver.plan.passing_geometry import borrowed_lane, find_passing
from stucksolver.scene import LineKind, ObjectKind, PlanFailure, RejectCode
from worlds import LANE_M, World, straight_road, thing

GUARD = Guard()
ROAD = straight_road()
MULTI = straight_road(left=LineKind.BROKEN, oncoming=None)
NOSE_M = 2.45
FAR_EDGE_M = 1.5 * LANE_M
PAST = {speed: BorrowOncomingLane(past_object_id="lead", speed_mps=speed) for speed in (2.0, 5.0, 5.5)}


def lead(gap_m: float, width: float, length: float, y: float = 0.0):
    return thing("lead", 50.0 + NOSE_M + gap_m + length / 2, y, width=width, length=length, hazard=True)


def bin_at(x: float):
    return thing("bin", x, FAR_EDGE_M - 0.4, kind=ObjectKind.PROP, width=0.6, length=0.6, height=1.0)


def accepted(world: World, plan, *, stops: bool = False) -> FrenetPath:
    verdict, proven = GUARD.accept([plan], world.view(), False, stops=stops)
    assert proven is not None, str(verdict)
    return proven.path


@pytest.mark.parametrize("aside_m", [-0.2, -0.06, -0.02, 0.0, 0.02, 0.06, 0.2])
@pytest.mark.parametrize(("width", "length"), [(2.16, 4.7), (2.05, 5.4), (2.6, 8.0), (2.5, 11.0)])
@pytest.mark.parametrize("speed", [2.0, 5.5])
def test_pass_five_meters_behind_a_wide_vehicle_is_accepted(aside_m, width, length, speed):
    """Whether the gap suffices does not hang on two centimeters of offset: the ego swings tighter, or slower."""
    path = accepted(World(ROAD, [lead(5.0, width, length)], y=aside_m), PAST[speed])
    assert path.returns and path.passes == ("lead",)


@pytest.mark.parametrize("gap_m", [4.0, 4.25])
def test_change_lane_too_near_for_a_shift_takes_a_searched_path(gap_m):
    """Where the tightest cosine is too near, the path turns at full lock for longer."""
    view = World(MULTI, [lead(gap_m, 1.9, 4.6)]).view()
    path = ChangeLane(side="left", distance_m=30.0, speed_mps=2.0).maneuver(view, BehaviorStart(50.0, 0.0, 0.0))
    assert float(gaps(view, path, 0.0, np.array([0])).min()) >= 0.3
    assert path.end_d == pytest.approx(LANE_M)


def test_no_path_error_names_object_lack_and_distance_to_back_up():
    view = World(MULTI, [lead(2.0, 1.9, 4.6)]).view()
    with pytest.raises(NoPathError) as raised:
        ChangeLane(side="left", distance_m=30.0, speed_mps=2.0).maneuver(view, BehaviorStart(50.0, 0.0, 0.0))
    error = raised.value
    assert error.failure is PlanFailure.NO_SPACE_TO_PULL_AROUND and error.object_id == "lead"
    assert error.short_m > 0.2 and 1.0 <= error.back_up_m <= 3.0
    back = World(MULTI, [lead(2.0 + error.back_up_m, 1.9, 4.6)])
    assert GUARD.accept([ChangeLane(side="left", distance_m=30.0, speed_mps=2.0)], back.view(), False)[1] is not None


def vans(apart_m: float, count: int):
    """Vans on alternating sides, the first in the ego's lane."""
    size = {"kind": ObjectKind.VAN, "width": 2.0, "length": 5.5, "hazard": True}
    return [
        thing("lead" if k == 0 else f"van{k}", 65.0 + apart_m * k, 0.0, **size)
        if k % 2 == 0
        else thing(f"van{k}", 65.0 + apart_m * k, LANE_M, yaw=math.pi, **size)
        for k in range(count)
    ]


@pytest.mark.parametrize(("apart_m", "count", "speed"), each_value([16.0, 22.0, 30.0, 45.0], [2, 3, 4], [2.0, 5.0]))
def test_pass_between_vans_on_alternating_sides_returns_or_stops_between_them(apart_m, count, speed):
    world = World(ROAD, vans(apart_m, count))
    drives_on, stops = accepted(world, PAST[speed]), accepted(world, PAST[speed], stops=True)
    assert drives_on.returns and abs(drives_on.end_d) < 0.01
    assert stops.stops and abs(stops.end_d) < 0.01
    third = 65.0 + 2 * apart_m - 2.75 if count > 2 else math.inf
    assert stops.end_s - NOSE_M > 65.0 + 2.75 and stops.end_s + NOSE_M < third


@pytest.mark.parametrize("bin_x", [56.0, 62.0, 64.0, 65.0, 66.0, 70.0, 76.0])
@pytest.mark.parametrize("speed", [2.0, 5.0])
def test_pass_with_a_bin_at_the_far_edge_leads_between_both(bin_x, speed):
    world = World(ROAD, [lead(10.25, 1.9, 4.6), bin_at(bin_x)], sight_m=400.0)
    view, path = world.view(), accepted(world, PAST[speed])
    near_m = gaps(view, path, 0.0, np.array([0, 1])).min(axis=0)
    assert (near_m > 0.45).all()


@pytest.mark.parametrize("edge_m", [2.0, 2.6, 3.2])
def test_find_passing_too_little_room_between_two_objects_names_the_far_one(edge_m):
    """Between a passed object and one beside it there must be room for a tracking fault on the far side."""
    far = thing("far", 65.0, edge_m + 0.5, kind=ObjectKind.BARRIER, width=1.0, length=1.0)
    view = World(ROAD, [lead(10.25, 1.9, 4.6), far]).view()
    with pytest.raises(NoPathError) as raised:
        find_passing(view, BehaviorStart(50.0, 0.0, 0.0), "lead", borrowed_lane(view, 50.0), 2.0)
    assert raised.value.failure is PlanFailure.LANE_TOO_NARROW
    assert raised.value.object_id == "far" and raised.value.short_m > 0.0


def test_find_passing_offset_lies_in_the_middle_of_a_narrow_passage():
    view = World(ROAD, [lead(10.25, 1.9, 4.6), bin_at(65.0)]).view()
    passing = find_passing(view, BehaviorStart(50.0, 0.0, 0.0), "lead", borrowed_lane(view, 50.0), 2.0)
    right, left = 0.95, FAR_EDGE_M - 0.4 - 0.3
    assert passing.offset_m == pytest.approx((right + left) / 2) and passing.slowly
    assert passing.least_offset_m == pytest.approx(right + 0.5 + 0.925)


def test_find_passing_ignores_objects_that_are_not_beside_the_pass():
    objects = [lead(10.25, 1.9, 4.6), bin_at(40.0), bin_at(90.0).model_copy(update={"id": "beyond"})]
    view = World(ROAD, objects).view()
    passing = find_passing(view, BehaviorStart(50.0, 0.0, 0.0), "lead", borrowed_lane(view, 50.0), 2.0)
    assert passing.offset_m == pytest.approx(0.95 + 1.2 + 0.925) and not passing.slowly


ASKEW = each_value([-25.0, -20.0, -15.0, 15.0, 20.0, 25.0], [-1.5, -0.8, 0.0, 0.8, 1.5])


@pytest.mark.parametrize(("degrees", "y"), ASKEW)
@pytest.mark.parametrize("plan", [KeepLane(distance_m=30.0, speed_mps=4.0), RejoinRoute()], ids=lambda plan: plan.name)
def test_turned_ego_on_a_free_road_gets_back_into_its_lane(degrees, y, plan):
    """The path begins in the ego's direction, so that a stack can drive it, and ends in the middle of the lane."""
    yaw = math.radians(degrees)
    world = World(straight_road(left=LineKind.BROKEN), [], y=y, yaw=yaw)
    if y - 0.925 * math.cos(yaw) + 2.45 * math.sin(yaw) < -LANE_M / 2:
        pytest.skip("the nose is beyond the edge of the road already, and would move further out")
    path = accepted(world, plan)
    assert abs(float(path.heading()[0]) - yaw) < 0.1
    assert abs(path.end_d) < 0.05 and abs(float(path.heading()[-1])) < 0.05


def test_turned_ego_with_its_nose_over_the_edge_is_told_to_back_up():
    """Ahead its nose only moves further out; after a short way back there is a path."""
    world = World(ROAD, [], y=-0.3, yaw=math.radians(-25.0))
    verdict, proven = GUARD.accept([RejoinRoute()], world.view(), False)
    assert proven is None and verdict.codes == (RejectCode.OFF_ROAD,)
    world.x, world.yaw = world.x - 2.0, world.yaw * math.exp(-2.0 / 3.0)
    world.y = -0.3 + 2.0 * math.tan(math.radians(20.0))
    assert GUARD.accept([RejoinRoute()], world.view(), False)[1] is not None


def test_turned_ego_beside_an_object_steers_clear_of_it():
    world = World(ROAD, [thing("cone", 60.0, 1.6, kind=ObjectKind.CONE)], y=-0.4, yaw=0.3)
    view, path = world.view(), accepted(world, KeepLane(distance_m=30.0, speed_mps=3.0))
    assert float(gaps(view, path, 0.3, np.array([0])).min()) >= 0.3


@pytest.mark.parametrize("gap_m", [3.4, 4.0])
def test_nudge_close_behind_an_object_takes_a_searched_path_in_its_lane(gap_m):
    object_ = thing("box", 50.0 + NOSE_M + gap_m + 0.3, -1.35, kind=ObjectKind.PROP, width=0.7, length=0.6)
    wide = ROAD.model_copy(
        update={"key": "wide", "lanes": tuple(x.model_copy(update={"width_m": (5.5,) * 401}) for x in ROAD.lanes[:1])}
    )
    world = World(wide, [object_])
    nudge = Nudge(side="left", offset_m=0.8, distance_m=15.0)
    path = nudge.maneuver(world.view(), BehaviorStart(50.0, 0.0, 0.0))
    assert path.stops and float(gaps(world.view(), path, 0.0, np.array([0])).min()) >= 0.3


def test_bounded_speed_beside_a_near_object_is_walking_pace():
    view = World(ROAD, [thing("box", 70.0, -1.5, kind=ObjectKind.PROP, width=0.5, length=0.5)]).view()
    s = 50.0 + 0.5 * np.arange(80)
    d = np.interp(s, [50.0, 60.0], [0.6, 0.0])
    path = bounded_speed(view, FrenetPath(s, d, np.full(80, 8.0)), 0.0)
    gap = gaps(view, path, 0.0, np.array([0]))[:, 0]
    assert float(gap.min()) < 0.45 and float(path.speed[gap.argmin()]) == pytest.approx(behavior.CREEP_MPS)
    assert float(path.speed[-1]) > 4.0


def test_lack_toward_objects_is_zero_alongside_and_positive_toward_them():
    view = World(ROAD, [thing("box", 70.0, 2.5, kind=ObjectKind.PROP, width=0.5, length=0.5)]).view()
    s = 50.0 + 0.5 * np.arange(80)
    alongside, toward = np.full(80, 0.9), np.interp(s, [50.0, 72.0], [0.0, 0.9])
    assert lack_toward_objects(view, FrenetPath(s, alongside, np.full(80, 2.0)), 0.0) <= 0.0
    assert lack_toward_objects(view, FrenetPath(s, toward, np.full(80, 2.0)), 0.0) > 0.3


def test_guard_lays_out_the_same_plan_again_from_the_kept_search():
    """Laying out a plan twice on one tick searches once, so candidates that differ in speed are cheap."""
    view = World(ROAD, [lead(5.0, 2.6, 8.0)], y=-0.2).view()
    first, again = (GUARD.lay_out([PAST[2.0]], view, False, NOBODY).path for _ in range(2))
    assert np.array_equal(first.d, again.d)
