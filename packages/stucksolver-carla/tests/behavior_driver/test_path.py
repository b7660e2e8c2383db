"""What a path to drive promises, whatever its shape."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stucksolver_carla.drivers.behavior import DrivePoint
from stucksolver_carla.drivers.behavior.path import PlanarPose, limited_speed, make_path
from stucksolver_carla.drivers.behavior.route_line import path_from_points, rejoining_length, rejoining_path

RADII = st.floats(6.0, 200.0) | st.floats(-200.0, -6.0)
LARGE_RADII = st.floats(9.0, 200.0) | st.floats(-200.0, -9.0)
"""Of bends that do not close to a circle within the path."""


def arc(radius: float, length: float = 60.0):
    """A bend that starts at the origin along x; a positive radius turns right (CARLA's frame)."""
    s = np.arange(0.0, length, 0.7)
    x, y = radius * np.sin(s / radius), radius * (1.0 - np.cos(s / radius))
    return make_path(x, y, np.full(len(s), 10.0))


@given(RADII)
def test_curvature_is_the_inverse_radius_right_positive(radius):
    path = arc(radius)
    middle = path.curvature[len(path.curvature) // 4 : -len(path.curvature) // 4]
    assert np.allclose(middle, 1.0 / radius, atol=0.01 + 0.05 / abs(radius))


@given(LARGE_RADII, st.floats(5.0, 30.0), st.floats(-2.0, 2.0), st.floats(-0.5, 0.5))
def test_a_pose_is_found_where_it_was_put(radius, s, lateral, heading):
    path = arc(radius, 45.0)
    x, y, yaw = (float(v[0]) for v in path.at(np.array([s])))
    pose = PlanarPose(x - lateral * math.sin(yaw), y + lateral * math.cos(yaw), yaw + heading)
    where = path.project(pose)
    assert where.s == pytest.approx(s, abs=0.4)
    assert where.lateral == pytest.approx(lateral, abs=0.05)
    assert where.heading == pytest.approx(heading, abs=0.08)


@given(st.lists(st.floats(0.0, 20.0), min_size=2, max_size=40), st.floats(0.5, 5.0))
def test_a_limited_speed_keeps_the_bound_and_the_deceleration(bounds, deceleration):
    s = np.arange(len(bounds), dtype=float)
    bound = np.array(bounds)
    speed = limited_speed(s, bound, deceleration)
    assert np.all(speed <= bound + 1e-6)
    assert np.all(speed[:-1] ** 2 - speed[1:] ** 2 <= 2.0 * deceleration + 1e-6)


@settings(max_examples=50)
@given(st.floats(-3.5, 3.5), st.floats(0.0, 10.0))
def test_rejoining_path_starts_at_ego_and_ends_on_route(lateral, speed):
    route = make_path(np.arange(0.0, 120.0), np.zeros(120), np.full(120, 10.0))
    back = rejoining_path(route, 20.0, lateral, rejoining_length(lateral, speed))
    assert (back.x[0], back.y[0]) == pytest.approx((20.0, lateral), abs=0.3)
    assert abs(back.y[-1]) < 1e-6
    assert np.all(np.abs(back.curvature) < 0.2)


def test_path_passing_place_twice_is_followed_in_order():
    there, back = np.arange(0.0, 50.0), np.arange(50.0, 0.0, -1.0)
    path = make_path(np.concatenate([there, back]), np.zeros(100), np.full(100, 5.0))
    assert path.project(PlanarPose(20.0, 0.0, 0.0)).s == pytest.approx(20.0, abs=0.3)
    assert path.project(PlanarPose(20.0, 0.0, math.pi)).s == pytest.approx(80.0, abs=1.3)


@pytest.mark.parametrize(
    ("points", "told"),
    [
        ([DrivePoint(0, 0, 3)], "at least 2 points"),
        ([DrivePoint(0, 0, 3), DrivePoint(0, 0, 3)], "two points at least"),
        ([DrivePoint(0, 0, 3), DrivePoint(math.nan, 0, 3)], "not finite"),
        ([DrivePoint(0, 0, 0), DrivePoint(5, 0, 3)], "use hold"),
    ],
)
def test_given_path_not_drivable_is_rejected_with_reason(points, told):
    with pytest.raises(ValueError, match=told):
        path_from_points(points, 0.0)
