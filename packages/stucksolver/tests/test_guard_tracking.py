"""Paths are examined as a vehicle drives them: from its real pose, with a body that is not tangent to them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stucksolver.guard import Guard
from stucksolver.guard.path_tracking import tracked_path
from stucksolver.plan.behaviors import BackUp, BorrowOncomingLane, ChangeLane, KeepLane
from stucksolver.plan.frenet_path import body_heading
from stucksolver.scene import LineKind, ObjectKind
from worlds import LANE_M, World, straight_road, thing

GUARD = Guard()
MULTI = straight_road(left=LineKind.BROKEN, oncoming=None)
ON = KeepLane(distance_m=40.0, speed_mps=5.0)


def bicycle(world, path, seconds=20.0, error_m=0.0, dt=0.05, speed=2.5):
    """Poses of a vehicle that keeps its center beside a path by an error, within its turning circle."""
    ego = world.ego()
    lever, lock = ego.limits.wheelbase_m / 2, 1 / ego.limits.min_turn_radius_m
    x, y, yaw, bend, poses = world.x, world.y, world.yaw, 0.0, []
    slope = np.gradient(path.d, path.s)
    for _ in range(int(seconds / dt)):
        if x > path.end_s - 1.0:
            break
        poses.append((x, y, yaw))
        course = math.atan(float(np.interp(x, path.s, slope)))
        beside = y - float(np.interp(x, path.s, path.d)) - error_m
        wanted = float(np.clip(-beside / 4.0, -0.45, 0.45)) + course - yaw - math.atan(lever * bend)
        bend = float(np.clip(np.clip(wanted, bend - 0.014, bend + 0.014), -lock, lock))
        rear_x, rear_y = x - lever * math.cos(yaw), y - lever * math.sin(yaw)
        rear_x, rear_y = rear_x + speed * dt * math.cos(yaw), rear_y + speed * dt * math.sin(yaw)
        yaw += speed * dt * bend
        x, y = rear_x + lever * math.cos(yaw), rear_y + lever * math.sin(yaw)
    return poses


def least_gap(world, poses):
    gaps = []
    for world.x, world.y, world.yaw in poses:
        gaps.append(world.clearance())
    return min(gaps)


@pytest.mark.parametrize("yaw", [-0.5, -0.35, 0.35, 0.5])
@pytest.mark.parametrize("side", [-1, 1])
def test_askew_start_into_object_beside_path_is_rejected(yaw, side):
    """A turned ego does not start if it would hit an object beside the path."""
    for x in (54.0, 56.0, 58.0, 60.0):
        for gap_m in (0.35, 0.6, 1.0):
            world = World(MULTI, [thing("parked", x, side * (0.93 + 0.95 + gap_m))], yaw=yaw)
            if world.clearance() < 0.05:
                continue
            proven = GUARD.accept([KeepLane(distance_m=30.0, speed_mps=2.2)], world.view(), False)[1]
            if proven is not None:
                assert least_gap(world, bicycle(world, proven.path)) > 0.0, (x, gap_m)


@pytest.mark.parametrize("x", np.arange(58.5, 66.0, 0.5))
@pytest.mark.parametrize("behavior", [ChangeLane(side="left", distance_m=30.0, speed_mps=2.5), "borrow"])
def test_swing_out_driven_exactly_keeps_promised_gap(x, behavior):
    road = MULTI if behavior != "borrow" else straight_road()
    plan = BorrowOncomingLane(past_object_id="lead", speed_mps=2.5) if behavior == "borrow" else behavior
    world = World(road, [thing("lead", x)])
    proven = GUARD.accept([plan], world.view(), False)[1]
    if proven is not None:
        course = proven.path.heading()
        yaw = body_heading(course, 0.0, world.ego().limits.wheelbase_m / 2)
        assert least_gap(world, list(zip(proven.path.s, proven.path.d, yaw, strict=True))) >= 0.3 - 1e-6


@pytest.mark.integration
@pytest.mark.parametrize("error_m", [0.3, 0.5, 0.7, 0.85])
@pytest.mark.parametrize("gap_m", [0.55, 0.6, 0.7, 0.8])
def test_recheck_constant_offset_stops_before_contact(error_m, gap_m):
    """A vehicle that stays beside its path is stopped before it touches an object."""
    world = World(MULTI, [thing("parked", 75.0, 0.93 + 0.95 + gap_m, kind=ObjectKind.BARRIER)])
    proven = GUARD.accept([ON], world.view(), False)[1]
    assert proven is not None
    for x in np.arange(51.0, 76.0, 0.1):
        world.x, world.y, world.speed = float(x), error_m, 5.0
        if not GUARD.recheck(proven, world.view()).accepted:
            break
    stop_m = 5.0**2 / (2 * 3.0) + 0.3 * 5.0
    touches = world.x + stop_m > 75.0 - 2.3 - 2.45 and error_m >= gap_m
    assert not touches, world.x


def test_the_body_is_not_tangent_where_the_path_bends():
    """On a circle the slip of the bicycle model's center is asin(l / R)."""
    course = np.arange(0.0, 3.0, 0.5 / 8.0)
    slip = course - body_heading(course, 0.0, 1.45)
    assert slip[-1] == pytest.approx(math.asin(1.45 / 8.0), abs=0.035)


def test_from_a_pose_on_the_path_nothing_changes():
    world = World(MULTI)
    proven = GUARD.accept([ON], world.view(), False)[1]
    way = tracked_path(proven.path, world.view(), GUARD.policy.tracking)
    assert np.allclose(way.d, proven.path.d) and np.allclose(way.yaw, 0.0)


@pytest.mark.parametrize("yaw", [-0.5, -0.2, 0.2, 0.5])
def test_an_askew_start_ends_on_the_path(yaw):
    world = World(MULTI, yaw=yaw)
    way = tracked_path(GUARD.lay_out([ON], world.view(), False, None).path, world.view(), GUARD.policy.tracking)
    assert abs(way.d[-1]) < 0.05 and abs(way.yaw[-1]) < 0.02
    poses = np.array(bicycle(world, way, seconds=8.0))
    assert np.abs(np.interp(poses[:, 0], way.s, way.d) - poses[:, 1]).max() < 0.35


def test_askew_start_into_adjacent_lane_is_rejected():
    """A turned ego does not swing into a vehicle in the adjacent lane."""
    world = World(MULTI, [thing("beside", 54.0, LANE_M - 0.6)], yaw=0.5)
    assert not GUARD.accept([ON], world.view(), False)[0].accepted


def backing_beside(yaw, behind_m, aside_m, mps, kind=ObjectKind.MOTORCYCLE):
    """Askew in the own lane, and somebody in the next one who comes up from behind."""
    world = World(MULTI, [thing("beside", 60.0 - behind_m, aside_m, kind=kind, speed=mps)], yaw=yaw)
    return world, GUARD.accept([BackUp(distance_m=5.0, speed_mps=1.4)], world.view(), False)[0]


@pytest.mark.parametrize("behind_m", [12.0, 16.0, 20.0])
def test_back_up_askew_tail_before_rear_traffic_is_rejected(behind_m):
    """A turned ego does not swing its tail in front of a vehicle that comes up beside it.

    In reverse along its heading, without steering, the tail is 1 m farther aside after 2 m.
    """
    side = 2.9
    for yaw, aside in ((-0.5, side), (0.5, -side)):
        world, verdict = backing_beside(yaw, behind_m, aside, 6.2)
        tail = [world.x - 2.45 * math.cos(yaw), world.y - 2.45 * math.sin(yaw)]
        assert abs(tail[1] - aside) < 2.0, "the tail points at their lane"
        assert not verdict.accepted


@pytest.mark.parametrize("yaw", [0.0, 0.05])
def test_back_up_straight_ignores_traffic_in_adjacent_lane(yaw):
    """Traffic in the adjacent lane does not keep the ego from backing up straight."""
    assert backing_beside(yaw, 16.0, -3.2, 6.2)[1].accepted
