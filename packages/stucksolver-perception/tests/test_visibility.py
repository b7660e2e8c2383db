from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stucksolver_perception.free_space import EGO_RANGE_M, FreeSpace
from stucksolver_perception.rig import load_rig

LIDAR = load_rig().lidar
AHEAD = np.array([[0.0, 0.0], [80.0, 0.0]])


def cast(boxes=(), *, slope=0.0, dropped=0.0, seed=0, road=None):
    """A full turn over a plane that rises by `slope` along x, with boxes (x, y, half x, half y, height) on it.

    `road`: it is a road along x between these y, and beside it the land is lower by the third number.
    """
    down = np.radians(np.linspace(LIDAR.upper_deg, LIDAR.lower_deg, LIDAR.channels))
    round_ = np.arange(0.0, math.tau, math.tau / 937)
    elevation, azimuth = (item.ravel() for item in np.meshgrid(down, round_))
    ray = np.column_stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    up = LIDAR.mount.z_m
    with np.errstate(divide="ignore", invalid="ignore"):
        fall = slope * ray[:, 0] - ray[:, 2]
        reach = np.where(fall > 1e-9, up / fall, np.inf)
        if road is not None:
            right, left, lower = road
            beside = ~((reach * ray[:, 1] > right) & (reach * ray[:, 1] < left))
            reach = np.where(beside, reach * (up + lower) / up, reach)
        for x, y, half_x, half_y, height in boxes:
            low, high = np.array([x - half_x, y - half_y, slope * x - up]), np.array([x + half_x, y + half_y, 0.0])
            high[2] = slope * x + height - up
            near, far = np.sort(np.stack([low / ray, high / ray]), axis=0)
            enter, leave = near.max(1), far.min(1)
            reach = np.where((enter > 0) & (enter <= leave), np.minimum(reach, enter), reach)
    kept = (reach < LIDAR.range_m) & (np.random.default_rng(seed).random(len(reach)) >= dropped)
    return ray[kept] * reach[kept, None] + (0.0, 0.0, up)


def space(*boxes, **more):
    return FreeSpace.from_points(cast(boxes, **more), LIDAR)


def seen(where, x, y):
    return bool(where.is_proven_free(np.array([x]), np.array([y]))[0])


def test_free_space_empty_plain_reaches_last_ground_return():
    """An empty plain is free in all directions as far as the ground returns rays."""
    free = space(dropped=0.45)
    angle = np.linspace(-3.1, 3.1, 100)
    for distance in (5.0, 10.0, 20.0, 40.0):
        assert free.is_proven_free(distance * np.cos(angle), distance * np.sin(angle)).mean() > 0.98
    assert 45.0 < free.free_length_along_m(AHEAD) <= LIDAR.range_m
    assert not seen(free, 200.0, 0.0)


def test_no_return_is_no_evidence():
    nothing = FreeSpace.from_points(np.zeros((0, 4), np.float32), LIDAR)
    assert not nothing.is_proven_free(np.linspace(-80, 80, 50), np.linspace(-80, 80, 50)).any()
    assert nothing.free_length_along_m(AHEAD) <= EGO_RANGE_M
    half = cast()
    half = FreeSpace.from_points(half[half[:, 0] > 0.0], LIDAR)
    assert seen(half, 20.0, 3.0)
    assert not seen(half, -20.0, 3.0)


def test_a_van_hides_what_stands_behind_it_and_nothing_beside():
    hidden = space((15.0, 0.0, 2.5, 1.0, 2.4))
    assert not seen(hidden, 25.0, 0.0)
    assert not seen(hidden, 45.0, 0.0)
    assert seen(hidden, 10.0, 0.0)
    assert seen(hidden, 25.0, 6.0)
    assert hidden.free_length_along_m(AHEAD) == pytest.approx(12.5, abs=1.0)


@pytest.mark.parametrize("lower", [0.4, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("slope", [0.0, 0.05, -0.05])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_free_space_raised_road_is_visible_both_ways(lower, slope, side):
    """A road that is higher than the land beside it is visible ahead and behind.

    Found on a narrow road: the field counted as the ground, and the road behind the ego as an obstacle of 0.5 m
    that occludes the space beyond. The ego never backed up.
    """
    right, left = sorted((-1.8 * side, 5.0 * side))
    free = space(road=(right, left, lower), slope=slope, dropped=0.45)
    for way in (1.0, -1.0):
        assert free.free_length_along_m(way * AHEAD) > 30.0
        assert free.free_length_along_m(way * AHEAD + (0.0, 3.0 * side)) > 30.0
    taken = space((way * 20.0, 0.0, 1.0, 0.9, 1.6), road=(right, left, lower), slope=slope, dropped=0.45)
    assert taken.free_length_along_m(way * AHEAD) < 20.0
    assert not seen(taken, way * 24.0, 0.0)


def test_free_space_low_object_and_bridge_do_not_occlude():
    """The space beyond a low object and below a bridge is visible."""
    assert space((15.0, 0.0, 0.2, 0.2, 0.6)).free_length_along_m(AHEAD, bridge_m=4.0) > 40.0
    points = cast()
    bridge = np.array([[30.0, y, z] for y in np.arange(-8, 8, 0.2) for z in (4.5, 5.0)])
    assert FreeSpace.from_points(np.concatenate([points, bridge]), LIDAR).free_length_along_m(AHEAD) > 45.0


@pytest.mark.parametrize("slope", [-0.06, -0.03, 0.03, 0.06])
def test_a_slope_is_ground_and_not_a_wall(slope):
    assert space(slope=slope).free_length_along_m(AHEAD) > 25.0
    assert not seen(space((15.0, 0.0, 2.0, 1.0, 2.0), slope=slope), 20.0, 0.0)


@pytest.mark.integration
@settings(max_examples=25, deadline=None)
@given(st.floats(7.0, 40.0), st.floats(-math.pi, math.pi), st.floats(1.2, 3.0), st.integers(0, 99))
def test_the_middle_of_a_vehicle_is_never_called_free(distance, angle, height, seed):
    x, y = distance * math.cos(angle), distance * math.sin(angle)
    assert not seen(space((x, y, 0.9, 0.9, height), dropped=0.45, seed=seed), x, y)


@pytest.mark.integration
@settings(max_examples=25, deadline=None)
@given(st.floats(6.0, 40.0), st.floats(-20.0, 20.0), st.floats(0.3, 2.5), st.integers(0, 9))
def test_free_space_added_object_never_extends_it(x, y, height, seed):
    """One more object never extends the free space behind it."""
    beyond = np.linspace(1.05, 1.6, 12)
    with_it = space((x, y, 0.8, 0.8, height), dropped=0.3, seed=seed).is_proven_free(x * beyond, y * beyond)
    without = space(dropped=0.0, seed=seed).is_proven_free(x * beyond, y * beyond)
    assert not (with_it & ~without).any()


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(st.floats(-80, 80), st.floats(-80, 80)), min_size=2, max_size=6))
def test_a_line_is_never_seen_for_longer_than_it_is(corners):
    line = np.array(corners)
    length = float(np.hypot(*np.diff(line, axis=0).T).sum())
    assert 0.0 <= FREE.free_length_along_m(line) <= length + 1e-9


def test_free_space_camera_extends_except_behind_lidar_objects():
    """The camera extends sight ahead, but not through objects that the LiDAR measured."""
    cone = np.radians([-30.0, 0.0, 30.0])
    assert space().extended(cone, np.full(3, 160.0)).free_length_along_m(
        np.array([[0.0, 0.0], [200.0, 0.0]])
    ) == pytest.approx(160.0, abs=0.5)
    hidden = space((15.0, 0.0, 2.5, 1.0, 2.4)).extended(cone, np.full(3, 160.0))
    assert hidden.free_length_along_m(AHEAD) < 14.0
    assert seen(hidden, 100.0, 30.0)
    assert not seen(hidden, -100.0, 0.0)
    assert not seen(hidden, 100.0, 70.0)
    with pytest.raises(ValueError, match="ascending"):
        space().extended(np.array([0.3, 0.1]), np.array([100.0, 100.0]))


FREE = space()


def test_blocked_otherwise_excludes_tall_known_objects():
    """Tall returns that come from no known object are distinguished."""
    van, wall = (15.0, 0.0, 2.5, 1.0, 2.0), (15.0, 12.0, 2.5, 1.0, 2.0)
    both = space(van, wall)
    ahead, aside = (int((angle + math.pi) / math.tau * 360) for angle in (0.01, math.atan2(12.0, 13.0)))
    assert both.blocked_m[[ahead, aside]] == pytest.approx([12.5, 17.0], abs=1.0)
    known = both.blocked_otherwise(np.array([[15.0, 0.1, 0.0, 2.4, 1.0]]))
    assert math.isinf(known[ahead])
    assert known[aside] == both.blocked_m[aside]
    nothing_known = both.blocked_otherwise(np.zeros((0, 5)))
    assert (nothing_known == both.blocked_m).all()
