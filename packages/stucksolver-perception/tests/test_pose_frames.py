"""Boxes and points between the local frame and the vehicle's."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver_perception.measurements import PoseEstimate
from stucksolver_perception.vehicle_frame import into_vehicle, points_into_vehicle

FAR = st.floats(-500.0, 500.0)
YAW = st.floats(-math.pi, math.pi)


def pose(x, y, z, yaw):
    return PoseEstimate(0.0, x, y, z, yaw, 0.0, 0.0, np.eye(4))


def test_into_vehicle_box_north_of_west_heading_is_right():
    """A box to the north of a car that heads west is on its right."""
    west = pose(100.0, 50.0, 4.0, math.pi)
    (box,) = into_vehicle(np.array([[100.0, 60.0, 5.0, 4.5, 2.0, math.pi / 2.0]]), west)
    assert box[:3] == pytest.approx([0.0, -10.0, 1.0])
    assert box[3:5].tolist() == [4.5, 2.0]
    assert box[5] == pytest.approx(-math.pi / 2.0)


@given(FAR, FAR, YAW, st.tuples(FAR, FAR, FAR, YAW))
def test_into_vehicle_box_and_back_is_unchanged(x, y, yaw, row):
    """A box that is moved into the vehicle frame and back is where it was."""
    box = np.array([row])
    (moved,) = into_vehicle(box, pose(x, y, 2.0, yaw))
    c, n = math.cos(yaw), math.sin(yaw)
    back = (x + c * moved[0] - n * moved[1], y + n * moved[0] + c * moved[1], moved[2] + 2.0)
    assert back == pytest.approx(row[:3], abs=1e-6)
    assert -math.pi <= moved[3] <= math.pi
    assert math.remainder(moved[3] + yaw - row[3], math.tau) == pytest.approx(0.0, abs=1e-9)


@given(FAR, FAR, YAW, st.lists(st.tuples(FAR, FAR), max_size=4))
def test_points_move_as_the_middles_of_boxes_do(x, y, yaw, rows):
    points = np.array(rows, np.float64).reshape(-1, 2)
    boxes = np.concatenate([points, np.zeros((len(points), 2))], axis=1)
    at = pose(x, y, 0.0, yaw)
    np.testing.assert_allclose(points_into_vehicle(points, at), into_vehicle(boxes, at)[:, :2], atol=1e-9)


def test_what_is_given_is_not_written_to():
    boxes = np.array([[1.0, 2.0, 3.0, 0.5]])
    into_vehicle(boxes, pose(9.0, 9.0, 9.0, 1.0))
    assert boxes.tolist() == [[1.0, 2.0, 3.0, 0.5]]
