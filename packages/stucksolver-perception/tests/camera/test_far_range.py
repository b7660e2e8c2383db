"""Ranges of far vehicles, by the road and by size."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver_perception.camera.far_detector import FarDetections
from stucksolver_perception.camera.far_lane_placement import place_on_lane, resampled
from stucksolver_perception.camera.far_range import RangeModel, far_places, ranges_of
from stucksolver_perception.measurements import Floats
from stucksolver_perception.rig import load_rig

CAMERA = load_rig().camera
WIDTH_M, HEIGHT_M, HALF_M = 1.9, 1.5, 2.3
SIZE_SIGMA, ROW_SIGMA = 0.08, 1.5
_BY_AREA = float(np.log(CAMERA.focal_px) + 0.5 * np.log(WIDTH_M * HEIGHT_M))
MODEL = RangeModel(
    row_bias_px=0.0,
    row_sigma_px=ROW_SIGMA,
    row_noise_px=0.5,
    size=((_BY_AREA, -0.5, -0.5),) * 3,
    size_sigma=(SIZE_SIGMA,) * 3,
    half_length_m=(HALF_M,) * 3,
    inflation=1.0,
)


def cars(x: Floats, y: Floats, scale: Floats | float = 1.0, rows_px: Floats | float = 0.0) -> FarDetections:
    """What is seen of cars whose middles are at x, y on a flat road; of other sizes, and rows off by some pixels."""
    away = np.hypot(x - CAMERA.mount.x_m, y)
    column, row, _ = CAMERA.project(np.stack([x, y, np.zeros(len(x))], 1))
    row = CAMERA.height_px / 2 + CAMERA.focal_px * CAMERA.mount.z_m / (away - HALF_M) + rows_px
    n = len(x)
    width, height = (CAMERA.focal_px * side * scale / away for side in (WIDTH_M, HEIGHT_M))
    label = np.zeros(n, np.int64)
    return FarDetections(0.0, column, row, width, height, np.ones(n), label, np.ones(n), np.zeros(2))


def test_far_places_standard_car_on_flat_road_is_exact() -> None:
    """A car of the usual size on a flat road gets its true place."""
    x, y = np.array([45.0, 90.0, 165.0, 200.0]), np.array([3.5, -3.5, 3.5, 0.0])
    places = far_places(cars(x, y), CAMERA, MODEL)
    assert places.range_m == pytest.approx(np.hypot(x - CAMERA.mount.x_m, y), rel=2e-3)
    assert places.xy == pytest.approx(np.stack([x, y], 1), rel=5e-3, abs=0.05)


def test_two_thirds_of_cars_are_within_one_standard_deviation() -> None:
    random, n = np.random.default_rng(3), 4000
    x = random.uniform(60.0, 200.0, n)
    found = cars(x, np.zeros(n), np.exp(random.normal(0.0, SIZE_SIGMA, n)), random.normal(0.0, ROW_SIGMA, n))
    range_m, sigma_m = ranges_of(found, CAMERA, MODEL)
    within = np.mean(np.abs(range_m - (x - CAMERA.mount.x_m)) < sigma_m)
    assert 0.63 < within < 0.78


def test_range_with_contradicting_row_and_size_is_less_certain() -> None:
    """A row and a size that contradict each other make the range less certain."""
    x, y = np.array([100.0]), np.zeros(1)
    _, agreed = ranges_of(cars(x, y), CAMERA, MODEL)
    _, torn = ranges_of(cars(x, y, 1.0, np.array([12.0])), CAMERA, MODEL)
    assert torn[0] > 1.5 * agreed[0]


@given(st.floats(30.0, 250.0), st.floats(-20.0, 20.0))
def test_far_covariance_is_positive_and_longest_along_ray(x: float, y: float) -> None:
    """The covariance is positive and longest along the line of sight."""
    places = far_places(cars(np.array([x]), np.array([y])), CAMERA, MODEL)
    values, vectors = np.linalg.eigh(places.covariance[0])
    assert values.min() > 0.0
    sight = places.xy[0] - [CAMERA.mount.x_m, 0.0]
    assert abs(vectors[:, 1] @ sight) / np.hypot(*sight) > 0.99


def test_on_lane_known_heights_place_car_on_slope() -> None:
    """On a lane with known heights, a car on a slope gets its true place."""
    x = np.arange(0.0, 250.0, 5.0)
    line = np.stack([x, np.full(len(x), 3.5), 0.03 * np.maximum(x - 40.0, 0.0)], 1)
    middle = np.array([[150.0, 3.5, 0.03 * 110.0]])
    near_end = np.array([[150.0 - HALF_M, 3.5, 0.03 * (110.0 - HALF_M)]])
    plain = cars(middle[:, 0], middle[:, 1])
    _, row, _ = CAMERA.project(near_end)
    found = FarDetections(
        0.0,
        CAMERA.project(middle)[0],
        row,
        plain.width,
        plain.height,
        plain.score,
        plain.label,
        plain.towards,
        plain.look,
    )
    placed = place_on_lane(found, CAMERA, MODEL, line)
    assert placed.along_m[0] == pytest.approx(150.0, abs=2.0 * placed.sigma_m[0])
    assert placed.misfit[0] < 2.0
    assert far_places(found, CAMERA, MODEL).range_m[0] != pytest.approx(149.2, abs=10.0)


def test_a_car_fits_its_own_lane_better_than_the_next() -> None:
    x = np.arange(0.0, 250.0, 5.0)
    found = cars(np.array([80.0]), np.array([3.5]))
    own, other = (place_on_lane(found, CAMERA, MODEL, np.stack([x, np.full(len(x), y)], 1)) for y in (3.5, -3.5))
    assert own.misfit[0] < 1.0 < 9.0 < other.misfit[0]


def test_a_lane_behind_the_car_fits_nothing() -> None:
    line = np.array([[-100.0, 0.0], [-10.0, 0.0]])
    assert np.isinf(place_on_lane(cars(np.array([80.0]), np.zeros(1)), CAMERA, MODEL, line).misfit).all()


def test_a_line_is_walked_in_equal_steps() -> None:
    points, along = resampled(np.array([[0.0, 0.0, 0.0], [10.0, 0.0, 1.0], [10.0, 5.0, 1.0]]), 2.5)
    assert along == pytest.approx(np.arange(0.0, 15.1, 2.5))
    assert points[-1] == pytest.approx([10.0, 5.0, 1.0])
