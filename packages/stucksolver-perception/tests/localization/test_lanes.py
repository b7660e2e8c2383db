from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver_perception.localization import match
from stucksolver_perception.measurements import PoseEstimate

HALF_M = 1.75


def straight(offset, *, backwards=False):
    x = np.linspace(0.0, 100.0, 11)
    return np.column_stack([x, np.full(11, offset), np.full(11, math.pi if backwards else 0.0)])


def pose(x=50.0, y=0.0, yaw=0.0, sigma=0.2):
    return PoseEstimate(0.0, x, y, 0.0, yaw, 0.0, 0.0, np.diag([sigma**2, sigma**2, 0.01**2, 0.1]))


ROAD = [straight(0.0), straight(3.5), straight(7.0, backwards=True)]


def test_match_present_lane_is_first_and_nearly_certain():
    best, *others = match(pose(y=0.4), ROAD, HALF_M)
    assert best.line == 0
    assert best.probability > 0.9
    assert best.lateral_m == pytest.approx(0.4)
    assert all(other.probability < 0.1 for other in others)


def test_a_vague_pose_between_two_lanes_leaves_both_open():
    first, second, *_ = match(pose(y=1.75, sigma=1.0), ROAD, HALF_M)
    assert {first.line, second.line} == {0, 1}
    assert first.probability == pytest.approx(second.probability)


def test_the_heading_tells_the_oncoming_lane():
    assert match(pose(y=7.0), ROAD, HALF_M)[0].line != 2 or match(pose(y=7.0), ROAD, HALF_M)[0].probability < 0.1
    assert match(pose(y=7.0, yaw=math.pi), ROAD, HALF_M)[0].line == 2


def test_left_is_positive_in_the_direction_of_the_traffic():
    (found,) = [item for item in match(pose(y=7.5, yaw=math.pi), ROAD, HALF_M) if item.line == 2]
    assert found.lateral_m == pytest.approx(-0.5)


def test_lanes_that_end_before_are_left_out():
    assert match(pose(x=120.0), ROAD, HALF_M) == []
    assert len(match(pose(x=101.0), ROAD, HALF_M)) == 3


@given(st.floats(-30, 30), st.floats(-3.1, 3.1), st.floats(0.01, 5.0))
def test_probabilities_never_add_up_to_more_than_one(y, yaw, sigma):
    found = match(pose(y=y, yaw=yaw, sigma=sigma), ROAD, HALF_M)
    assert 0.0 <= sum(item.probability for item in found) <= 1.0 + 1e-9


@given(st.floats(-50, 50), st.floats(-50, 50), st.floats(-3, 3), st.floats(-2, 2))
def test_the_answer_is_the_same_wherever_the_local_frame_begins(x, y, turn, off):
    cos, sin = math.cos(turn), math.sin(turn)
    spin = np.array([[cos, -sin], [sin, cos]])
    moved = [np.column_stack([line[:, :2] @ spin.T + (x, y), line[:, 2] + turn]) for line in ROAD]
    at = spin @ (50.0, off) + (x, y)
    there = {item.line: item for item in match(pose(at[0], at[1], turn), moved, HALF_M)}
    for item in match(pose(y=off), ROAD, HALF_M):
        assert there[item.line].lateral_m == pytest.approx(item.lateral_m, abs=1e-6)
        assert there[item.line].probability == pytest.approx(item.probability, abs=1e-6)
