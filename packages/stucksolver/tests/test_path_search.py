"""Paths searched from pose to pose: clear, drivable, within the borders, the same on both sides and both ways."""

from __future__ import annotations

import gc
import math
import weakref

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from alike import mirrored, turned
from stucksolver.guard import Guard, GuardPolicy, RejectCode
from stucksolver.plan import object_gaps, path_lattice, path_search
from stucksolver.plan.behaviors import BehaviorStart, BorrowOncomingLane, NoPathError
from stucksolver.plan.frenet_path import STEP_M, FrenetPath
from stucksolver.plan.path_search import Goal, search_path
from stucksolver.scene import ObjectKind
from stucksolver.scene.boxes import separation
from stucksolver.scene.frenet_scene import FrenetScene
from test_guard_proofs import MANY
from worlds import LANE_M, World, bent_road, straight_road, thing

ROAD = straight_road()
FRONT_M = 2.45
HOME = Goal(0.0, 100.0)


def start_of(view: FrenetScene) -> BehaviorStart:
    return BehaviorStart(view.ego_s, view.ego_d, max(view.ego.speed_mps, 0.0), view.ego_yaw)


def gaps(view: FrenetScene, path: FrenetPath, yaw: float) -> np.ndarray:
    """(stations, objects): gaps of the body, meters, as the guard measures them."""
    body = path.s[:, None], path.d[:, None], path.body(yaw, view.ego.limits.wheelbase_m)[:, None]
    return separation(
        body,
        (view.ego.length_m / 2, view.ego.width_m / 2),
        (view.s, view.d, view.yaw),
        (view.half_length, view.half_width),
    )


def assert_sound(view: FrenetScene, path: FrenetPath, start: BehaviorStart, goal: Goal) -> None:
    """The path keeps clearance, turning radius and borders, from the exact pose to the goal."""
    assert path.s[0] == pytest.approx(start.s_m) and path.d[0] == pytest.approx(start.d_m)
    assert path.end_d == pytest.approx(goal.d_m) and path.end_s <= goal.latest_s_m + path_search.STRAIGHT_M
    assert np.diff(path.s) == pytest.approx(STEP_M)
    bend = np.abs(np.diff(path.d, 2)) / STEP_M**2
    assert float(bend[:-1].max(initial=0.0)) <= 1.05 / view.ego.limits.min_turn_radius_m
    assert abs(float(path.heading()[0]) - start.yaw_rad) < 0.1
    assert abs(float(path.heading()[-1])) < 0.09  # one station at full lock
    if len(view.objects):
        gap = gaps(view, path, start.yaw_rad)
        least = np.where(view.vulnerable, 1.0, 0.3)
        assert (gap >= np.minimum(least, gap[0] - 0.05) - 1e-9).all()
    yaw = path.body(start.yaw_rad, view.ego.limits.wheelbase_m)
    reach = view.ego.width_m / 2 * np.cos(yaw) + view.ego.length_m / 2 * np.abs(np.sin(yaw))
    low, high = (np.interp(path.s, view.frame.s, border) for border in view.frame.drivable)
    beyond = np.maximum(path.d + reach - high, low - path.d + reach)
    assert (beyond <= max(0.15, float(beyond[0]) + 0.15)).all()


obstacles = st.builds(
    lambda gap, y, width, length, yaw, kind: (gap, y, width, length, yaw, kind),
    st.floats(2.0, 25.0),
    st.floats(-2.0, 4.0),
    st.floats(0.4, 2.6),
    st.floats(0.4, 8.0),
    st.floats(-0.4, 0.4),
    st.sampled_from([ObjectKind.CAR, ObjectKind.PROP, ObjectKind.BARRIER, ObjectKind.PEDESTRIAN]),
)
worlds_with = st.builds(
    lambda y, yaw, found: (y, yaw, found), st.floats(-0.6, 3.0), st.floats(-0.4, 0.4), st.lists(obstacles, max_size=3)
)


def world_of(drawn: tuple) -> World:
    y, yaw, found = drawn
    objects = [
        thing(f"o{k}", 50.0 + FRONT_M + gap + length / 2, at, kind=kind, width=width, length=length, yaw=turn)
        for k, (gap, at, width, length, turn, kind) in enumerate(found)
    ]
    return World(ROAD, objects, y=y, yaw=yaw)


def found(view: FrenetScene, goal: Goal, **more) -> FrenetPath | NoPathError:
    try:
        return search_path(view, start_of(view), goal, **more)
    except NoPathError as error:
        return error


@given(drawn=worlds_with, to=st.sampled_from([0.0, 2.9, LANE_M]))
@settings(max_examples=4 * MANY, deadline=None)
def test_search_path_found_is_clear_drivable_and_on_the_road(drawn, to):
    view = world_of(drawn).view()
    goal = Goal(to, 100.0)
    path = found(view, goal)
    if isinstance(path, NoPathError):
        assert path.short_m is None or (path.object_id is not None and path.short_m >= 0.0)
        return
    assert_sound(view, path, start_of(view), goal)


@given(drawn=worlds_with, to=st.sampled_from([0.0, 2.9]))
@settings(max_examples=2 * MANY, deadline=None, derandomize=True)
def test_search_path_mirrored_world_gives_the_mirrored_path(drawn, to):
    world = world_of(drawn)
    path = found(world.view(), Goal(to, 100.0))
    other = found(FrenetScene(mirrored(world.surroundings())), Goal(-to, 100.0))
    assert isinstance(path, NoPathError) == isinstance(other, NoPathError)
    assume(isinstance(path, FrenetPath))
    # Of two motions of equal cost either may be smoothed, so the paths are alike and not equal.
    count = min(len(path.d), len(other.d))
    assert path.d[:count] == pytest.approx(-other.d[:count], abs=0.3)
    assert abs(len(path.d) - len(other.d)) <= 8


@given(drawn=worlds_with)
@settings(max_examples=2 * MANY, deadline=None, derandomize=True)
def test_search_path_does_not_depend_on_the_origin(drawn):
    world = world_of(drawn)
    path, other = found(world.view(), HOME), found(FrenetScene(turned(world.surroundings())), HOME)
    assert isinstance(path, NoPathError) == isinstance(other, NoPathError)
    if isinstance(path, FrenetPath):
        count = min(len(path.d), len(other.d))  # of two motions of equal cost, rounding decides
        assert path.d[:count] == pytest.approx(other.d[:count], abs=0.3)


def behind(drawn: tuple) -> World:
    """A world whose objects are behind the ego, in the same arrangement for an ego that looks back."""
    y, yaw, objects = drawn
    placed = [
        thing(f"o{k}", 150.0 - FRONT_M - gap - length / 2, -at, kind=kind, width=width, length=length, yaw=turn)
        for k, (gap, at, width, length, turn, kind) in enumerate(objects)
    ]
    return World(ROAD, placed, x=150.0, y=-y, yaw=yaw)


@given(drawn=st.tuples(st.floats(-0.6, 0.6), st.floats(-0.2, 0.2), st.lists(obstacles, max_size=2)))
@settings(max_examples=2 * MANY, deadline=None)
def test_search_path_in_reverse_is_clear_and_drivable(drawn):
    """In reverse the axle leads: its line keeps the turning radius, and the body stays clear all along."""
    view = behind(drawn).view().backwards
    start, goal = start_of(view), Goal(0.0, view.ego_s + 40.0)
    path = found(view, goal, reverse=True)
    if isinstance(path, NoPathError):
        return
    assert path.yaw is not None and path.yaw[0] == pytest.approx(start.yaw_rad)
    assert path.d[0] == pytest.approx(start.d_m) and path.end_d == pytest.approx(0.0)
    if len(view.objects):
        gap = gaps(view, path, start.yaw_rad)
        assert (gap >= np.minimum(np.where(view.vulnerable, 1.0, 0.3), gap[0] - 0.05) - 1e-9).all()
    lever = view.ego.limits.wheelbase_m / 2
    axle_s, axle_d = path.s - (-lever) * np.cos(path.yaw), path.d - (-lever) * np.sin(path.yaw)
    slope = np.gradient(axle_d, axle_s)
    assert np.arctan(slope)[1:-2] == pytest.approx(path.yaw[1:-2], abs=0.06)


def test_search_path_in_reverse_swings_round_an_object_behind():
    """Backing up past a bin behind the right rear corner moves aside and back again."""
    world = World(ROAD, [thing("bin", 138.0, -0.8, kind=ObjectKind.PROP, width=0.6, length=0.6)], x=150.0)
    view = world.view().backwards
    path = search_path(view, start_of(view), Goal(0.0, view.ego_s + 30.0, view.ego_s + 16.0), reverse=True)
    assert float(np.abs(path.d).max()) > 0.3 and float(gaps(view, path, 0.0).min()) > 0.3


def test_search_path_backwards_equals_forward_in_the_turned_world():
    """Looking back along the route is nothing else than driving the other way."""
    ahead = World(ROAD, [thing("lead", 70.0, 0.3)], x=50.0).view()
    back = World(ROAD, [thing("lead", 130.0, -0.3)], x=150.0).view().backwards
    out = search_path(ahead, start_of(ahead), Goal(LANE_M, ahead.ego_s + 50.0))
    # The lane to its left is beyond the road's right edge there, so the borders are those of the mirrored offsets.
    with pytest.raises(NoPathError):
        search_path(back, start_of(back), Goal(LANE_M, back.ego_s + 50.0))
    other = search_path(back, start_of(back), Goal(-LANE_M, back.ego_s + 50.0))
    assert float(out.d.max()) == pytest.approx(-float(other.d.min()), abs=0.3)


@pytest.mark.parametrize("radius_m", [30.0, -30.0])
def test_search_path_on_a_bend_keeps_the_turning_radius_in_the_plane(radius_m):
    world = World(bent_road(radius_m), [])
    x, y, heading = world.view().frame.to_local(np.array([10.0]), np.array([0.5]))
    world.x, world.y, world.yaw = float(x[0]), float(y[0]), float(heading[0]) + 0.2
    view = world.view()
    path = search_path(view, start_of(view), Goal(0.0, 40.0))
    bend = np.diff(path.d, 2) / STEP_M**2 + 1.0 / radius_m
    assert float(np.abs(bend).max()) <= 1.1 / view.ego.limits.min_turn_radius_m


def test_search_path_fast_start_keeps_the_lateral_acceleration():
    view = World(ROAD, [], speed=6.0).view()
    path = search_path(view, start_of(view), Goal(LANE_M, 100.0))
    bend = np.abs(np.diff(path.d, 2)) / STEP_M**2
    assert float(bend.max()) * 6.0**2 <= 1.1 * view.ego.limits.max_lateral_acceleration_mps2


@pytest.mark.parametrize("gap_m", [1.0, 2.0, 2.5, 3.0])
def test_search_path_without_room_says_what_is_missing(gap_m):
    """It says who is short and how far to back up. The proposed distance is enough, and half of the
    rest is not always wasted."""

    def tried(room_m: float) -> FrenetPath | NoPathError:
        lead = thing("lead", 50.0 + FRONT_M + room_m + 2.3)
        return found(World(ROAD, [lead]).view(), Goal(2.9, 100.0))

    error = tried(gap_m)
    assert isinstance(error, NoPathError)
    assert error.object_id == "lead" and error.short_m is not None and error.short_m > 0.0
    assert error.back_up_m is not None
    assert isinstance(tried(gap_m + error.back_up_m), FrenetPath)
    assert isinstance(tried(gap_m + error.back_up_m - 2.0), NoPathError)


def test_search_path_blocked_road_knows_no_distance_to_back_up():
    wall = thing("wall", 65.0, 1.75, width=6.8, kind=ObjectKind.BARRIER)
    error = found(World(ROAD, [wall]).view(), Goal(0.0, 100.0, 80.0))
    assert isinstance(error, NoPathError)
    assert error.object_id == "wall" and error.short_m > 1.0 and error.back_up_m is None


def test_search_path_same_tick_is_searched_once(monkeypatch):
    view = World(ROAD, [thing("lead", 62.0)]).view()
    path = search_path(view, start_of(view), Goal(2.9, 100.0))
    monkeypatch.setattr(path_search, "cheapest_motion", None)
    assert search_path(view, start_of(view), Goal(2.9, 100.0)) is path


def test_planner_constants_are_those_of_the_policy():
    policy = GuardPolicy()
    assert object_gaps.LEAST_GAP_M == policy.clearance.standing_gap_m < path_search.LEAST_CLEARANCE_M
    assert object_gaps.NEARER_M == path_search.NEARER_M == policy.clearance.nearer_m
    assert policy.clearance.tracked_gap_m == object_gaps.TRACKED_M
    assert policy.tracking.beside_m == object_gaps.BESIDE_M and policy.tracking.drift_mps == object_gaps.DRIFT_MPS
    assert policy.stopping.lag_s == object_gaps.LAG_S and policy.tracking.parallel_rad == object_gaps.PARALLEL
    assert policy.doors.reach_m == object_gaps.DOOR_M and policy.doors.part_of_length == object_gaps.DOORS_PART
    assert policy.tracking.error_m + policy.harm.touch_m < object_gaps.ERROR_M
    assert policy.tracking.straightens_m == path_lattice.STRAIGHTENS_M
    assert policy.clearance.vulnerable_gap_m < path_search.LEAST_VULNERABLE_CLEARANCE_M
    assert math.isclose(path_lattice.LAYER_M % STEP_M, 0.0)


def test_failed_search_does_not_keep_its_surroundings():
    """A vehicle searches for years: the surroundings of a tick end with it, also after a search without a path."""
    view = World(straight_road(), [thing("lead", 50.0 + 2.45 + 1.0 + 2.3)]).view()
    plan = [BorrowOncomingLane(past_object_id="lead", speed_mps=5.5)]
    verdict, _ = Guard().accept(plan, view, guided=False)
    assert RejectCode.NO_PATH in verdict.codes
    kept = weakref.ref(view)
    del view
    gc.collect()
    assert kept() is None
