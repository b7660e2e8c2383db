"""Noise of a detector: what it says of errors that are known."""

from __future__ import annotations

import numpy as np
import pytest

from lab.perception.evaluation.metrics.detector_noise import RINGS_M, LabelNoise, detector_noise
from lab.perception.evaluation.metrics.matching import TruthObjects
from stucksolver_perception.measurements import Detections

LOOKS = 400


def measured(shift_m: float, jitter_m: float, missed: int = 0) -> LabelNoise:
    """Of one parked car 10 m ahead, turned to the left, that is found `shift_m` ahead of its middle."""
    random = np.random.default_rng(0)
    found, reals = [], []
    middle, size, yaw = np.array([[10.0, 0.0, 0.75]]), np.array([[4.5, 1.9, 1.5]]), np.array([np.pi / 2])
    for look in range(LOOKS):
        reals.append(TruthObjects(np.array([0]), middle, size, yaw, np.zeros((1, 2)), np.array([True]), np.array([7])))
        place = middle + np.array([[0.0, shift_m + random.normal(0.0, jitter_m), 0.0]])
        one = Detections(0.1 * look, np.array([0]), np.array([0.9]), place, size, yaw + np.pi, np.array([[0.0, 1.0]]))
        found.append(one if look >= missed else one.part(np.zeros(1, np.bool_)))
    return detector_noise([(found, reals)])[RINGS_M[0]]["car"]


def test_an_error_that_stays_is_no_noise() -> None:
    noise = measured(shift_m=0.8, jitter_m=0.0)
    assert noise.jitter_m == pytest.approx((0.0, 0.0), abs=1e-9)
    assert noise.drift_m == pytest.approx((0.0, 0.0), abs=1e-9)


def test_detector_jitter_is_standard_deviation_along_axis() -> None:
    """Jitter is the standard deviation of one detection, and lies along the axis of the error."""
    along, across = measured(shift_m=0.0, jitter_m=0.1).jitter_m
    assert along == pytest.approx(0.1, rel=0.15)
    assert across == pytest.approx(0.0, abs=1e-9)


def test_detector_reversed_heading_counts_as_flip_without_yaw_error() -> None:
    """A car that is detected with the opposite heading counts as flipped and gives no yaw error."""
    noise = measured(shift_m=0.0, jitter_m=0.0)
    assert noise.flipped == 1.0
    assert noise.yaw_rad == pytest.approx(0.0, abs=1e-9)


def test_the_velocity_of_what_stands_is_an_error() -> None:
    assert measured(shift_m=0.0, jitter_m=0.0).standing_mps == pytest.approx((1.0, 0.0), abs=1e-9)


def test_what_is_not_found_lowers_recall() -> None:
    assert measured(shift_m=0.0, jitter_m=0.0, missed=LOOKS // 4).recall == 0.75
