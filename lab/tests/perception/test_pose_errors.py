from __future__ import annotations

import math

import numpy as np
import pytest

from lab.perception.evaluation.metrics.pose_errors import pose_errors

SURE = np.array([np.eye(2)])


def test_pose_error_across_heading_is_lateral() -> None:
    """An error across the heading is a lateral error, and one along the heading is not."""
    true = np.array([[0.0, 0.0, math.pi / 2.0, 5.0]])
    across = pose_errors(true + np.array([1.0, 0.0, 0.0, 0.0]), true, SURE)
    along = pose_errors(true + np.array([0.0, 1.0, 0.0, 0.0]), true, SURE)
    assert across is not None and along is not None
    assert (across.lateral_rms_m, across.position_rms_m) == (pytest.approx(1.0), pytest.approx(1.0))
    assert (along.lateral_rms_m, along.position_rms_m) == (pytest.approx(0.0), pytest.approx(1.0))


def test_headings_on_both_sides_of_south_are_near_each_other() -> None:
    found = pose_errors(np.array([[0.0, 0.0, 3.14, 0.0]]), np.array([[0.0, 0.0, -3.14, 0.0]]), SURE)
    assert found is not None
    assert found.yaw_rms_rad == pytest.approx(math.tau - 6.28, abs=1e-9)


def test_pose_ellipse_95_percent_ends_below_2_5_deviations() -> None:
    """The 95 % ellipse contains an error of 2.4 standard deviations, but not one of 2.5."""
    true = np.zeros((2, 4))
    off = np.array([[2.4, 0.0, 0.0, 0.0], [2.5, 0.0, 0.0, 0.0]])
    found = pose_errors(off, true, np.repeat(SURE, 2, axis=0))
    assert found is not None
    assert found.within_95 == 0.5


def test_no_moments_give_no_errors() -> None:
    assert pose_errors(np.zeros((0, 4)), np.zeros((0, 4)), np.zeros((0, 2, 2))) is None
