"""Sweeps brought into the frame of now."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver_perception.lidar.sweeps import SweepBuffer, is_uneven
from stucksolver_perception.measurements import Floats, LidarSweep, PoseEstimate, Singles

AWAY_M = st.floats(-50, 50)
YAW_RAD = st.floats(-math.pi, math.pi)


def pose(time_s: float, x_m: float = 0.0, y_m: float = 0.0, yaw_rad: float = 0.0) -> PoseEstimate:
    return PoseEstimate(time_s, x_m, y_m, 0.0, yaw_rad, 0.0, 0.0, np.eye(4))


def seen_from(at: PoseEstimate, places: Floats) -> Singles:
    """Places of the local frame (n, 3) as points of a sweep."""
    dx, dy = places[:, 0] - at.x_m, places[:, 1] - at.y_m
    cos, sin = math.cos(at.yaw_rad), math.sin(at.yaw_rad)
    columns = [cos * dx + sin * dy, cos * dy - sin * dx, places[:, 2], np.full(len(places), 0.5)]
    return np.stack(columns, axis=1).astype(np.float32)


@given(st.tuples(AWAY_M, AWAY_M, YAW_RAD), st.tuples(AWAY_M, AWAY_M, YAW_RAD))
def test_what_stands_stays_where_it_is_however_we_move(
    before: tuple[float, float, float], after: tuple[float, float, float]
) -> None:
    places = np.array([[10.0, 2.0, 1.0], [-5.0, 7.0, 0.5]])
    buffer = SweepBuffer()
    for past in (pose(0.0, *before), pose(0.1, *after)):
        buffer.add(LidarSweep(past.time_s, seen_from(past, places)), past)
    points = buffer.gather(pose(0.1, *after))
    np.testing.assert_allclose(points[:2, :3], points[2:, :3], atol=1e-4)
    np.testing.assert_allclose(points[:, 4], [0.0, 0.0, 0.1, 0.1], atol=1e-6)


def test_sweeps_older_than_the_horizon_are_forgotten() -> None:
    buffer = SweepBuffer(horizon_s=0.5)
    for i in range(40):
        now = pose(0.05 * i)
        buffer.add(LidarSweep(now.time_s, np.ones((1, 4), np.float32)), now)
    points = buffer.gather(now)
    assert len(points) == 10
    assert points[:, 4].max() == pytest.approx(0.45)


def test_flat_ground_is_kept_of_the_last_turn_only() -> None:
    buffer = SweepBuffer()
    road = [[10.0 + 0.1 * i, 0.2, 0.02, 0.2] for i in range(20)]
    bag = [[10.1, 10.1, 0.0, 0.2], [10.2, 10.1, 0.15, 0.2]]
    for i in range(4):
        buffer.add(LidarSweep(0.05 * i, np.array(road + bag, np.float32)), pose(0.05 * i))
    y = buffer.gather(pose(0.15))[:, 1]
    assert (y < 1.0).sum() == 2 * len(road)
    assert (y > 1.0).sum() == 4 * len(bag)


def test_uneven_keeps_high_points_when_flat_or_alone() -> None:
    """High points are kept even where they are flat or alone."""
    roof_and_head = np.array(
        [[10, 0, 1.5, 0.2], [10.1, 0, 1.5, 0.2], [30, 9, 1.7, 0.2], [500, 9, 1.7, 0.2]], np.float32
    )
    assert is_uneven(roof_and_head).all()


def test_more_points_than_allowed_are_thinned_out_among_the_older_ones() -> None:
    buffer = SweepBuffer(max_points=2500)
    for i in range(10):
        buffer.add(LidarSweep(0.05 * i, np.ones((1000, 4), np.float32)), pose(0.05 * i))
    ages = buffer.gather(pose(0.45))[:, 4]
    assert (ages < 0.075).sum() == 2000
    assert 0 < (ages > 0.075).sum() <= 508


def test_nothing_swept_is_no_points() -> None:
    assert SweepBuffer().gather(pose(1.0)).shape == (0, 5)


def test_a_sweep_out_of_order_is_refused() -> None:
    buffer = SweepBuffer()
    buffer.add(LidarSweep(1.0, np.ones((1, 4), np.float32)), pose(1.0))
    with pytest.raises(ValueError, match=r"0\.500 s after one of 1\.000 s"):
        buffer.add(LidarSweep(0.5, np.ones((1, 4), np.float32)), pose(0.5))
