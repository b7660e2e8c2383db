from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from made_up import CAR, detections, reals

from lab.perception.evaluation.metrics.box_errors import box_errors, size_overlap, turn_between
from lab.perception.evaluation.metrics.matching import match


def test_a_box_in_place_is_off_by_nothing() -> None:
    found, real = [detections((10.0, 0.0, 0.9))], [reals((10.0, 0.0))]
    errors = box_errors(match(found, real, CAR, 2.0), found, real)
    assert (errors.translation_m, errors.scale, errors.orientation_rad, errors.velocity_mps) == (0.0, 0.0, 0.0, 0.0)


def test_each_error_is_that_of_its_quantity() -> None:
    told, real = detections((10.0, 0.6, 0.9), yaw=0.3), [reals((10.8, 0.0))]
    found = [replace(told, velocity=np.array([[3.0, 4.0]]), size=np.array([[2.0, 2.0, 1.5]]))]
    errors = box_errors(match(found, real, CAR, 2.0), found, real)
    assert errors.translation_m == pytest.approx(1.0)
    assert errors.scale == pytest.approx(0.5)
    assert errors.orientation_rad == pytest.approx(0.3)
    assert errors.velocity_mps == pytest.approx(5.0)


def test_too_few_found_objects_give_no_error() -> None:
    found, real = [detections((0.0, 0.0, 0.9))], [reals(*[(10.0 * k, 0.0) for k in range(20)])]
    assert box_errors(match(found, real, CAR, 2.0), found, real).translation_m is None


def test_sizes_overlap_as_their_volumes_do() -> None:
    assert size_overlap(np.array([2.0, 2.0, 2.0]), np.array([2.0, 2.0, 2.0])) == 1.0
    assert size_overlap(np.array([4.0, 2.0, 1.0]), np.array([2.0, 4.0, 1.0])) == pytest.approx(4.0 / 12.0)


def test_headings_differ_by_the_smaller_angle() -> None:
    assert turn_between(3.1, -3.1) == pytest.approx(math.tau - 6.2)
    assert turn_between(0.0, math.pi, math.pi) == pytest.approx(0.0)
