"""Cells of the network to boxes."""

import math

import numpy as np
import pytest

from stucksolver_perception.lidar.decode import GROUPS, REGRESSION_SIZE, Calibration, boxes_of, decode, suppressed
from stucksolver_perception.lidar.grid import GRID
from stucksolver_perception.lidar_labels import LABELS

CAR, TRUCK, PEDESTRIAN = LABELS.index("car"), LABELS.index("truck"), LABELS.index("pedestrian")
EVERYTHING = Calibration((1.0,) * len(LABELS), (0.0,) * len(LABELS), (0.0,) * len(LABELS))


def box(x_m: float, y_m: float = 0.0, length_m: float = 4.5, width_m: float = 1.9) -> list[float]:
    return [x_m, y_m, 0.8, length_m, width_m, 1.5, 0.0, 0.0, 0.0]


def test_a_box_is_where_and_as_the_cell_says() -> None:
    told = np.array([[0.25, -0.5, 0.9, math.log(4.0), math.log(2.0), math.log(1.5), 1.0, 0.0, 1.0, -0.4]], np.float32)
    found = boxes_of(np.array([3 * GRID.columns + 7]), told)[0]
    x, y = GRID.x_min_m + 3.75 * GRID.cell_m, GRID.y_min_m + 7.0 * GRID.cell_m
    np.testing.assert_allclose(found, [x, y, 0.9, 4.0, 2.0, 1.5, math.pi / 2, 5.0, -2.0], rtol=1e-5)


def test_of_two_boxes_at_one_place_the_better_remains() -> None:
    kept = suppressed(np.array([CAR, TRUCK]), np.array([0.4, 0.8]), np.array([box(10.0), box(11.0)]))
    assert kept.tolist() == [1]


def test_suppressed_second_center_in_long_truck_is_dropped() -> None:
    """A second middle inside a long truck is not a second truck."""
    boxes = np.array([box(20.0, length_m=14.0, width_m=2.6), box(25.0)])
    assert suppressed(np.array([TRUCK, TRUCK]), np.array([0.9, 0.5]), boxes).tolist() == [0]


def test_cars_parked_side_by_side_and_people_in_pairs_remain() -> None:
    cars = np.array([box(10.0), box(10.0, 2.4)])
    assert len(suppressed(np.array([CAR, CAR]), np.array([0.9, 0.8]), cars)) == 2
    people = np.array([box(10.0, 0.0, 0.5, 0.5), box(10.0, 0.6, 0.5, 0.5)])
    assert len(suppressed(np.array([PEDESTRIAN] * 2), np.array([0.9, 0.8]), people)) == 2


def test_a_person_beside_or_in_front_of_a_car_remains() -> None:
    boxes = np.array([box(10.0), box(11.0, 0.0, 0.6, 0.6)])
    assert len(suppressed(np.array([CAR, PEDESTRIAN]), np.array([0.9, 0.8]), boxes)) == 2


def test_every_label_has_a_group() -> None:
    assert len(GROUPS) == len(LABELS)


def test_scores_are_calibrated_and_weak_ones_left_out() -> None:
    told = np.zeros((3, REGRESSION_SIZE), np.float32)
    told[:, 7] = 1.0
    slope, shift = (2.0,) * len(LABELS), (1.0,) * len(LABELS)
    calibration = Calibration(slope, shift, (0.5,) * len(LABELS))
    cells = np.array([0, 4000, 8000])
    found = decode(np.array([1.0, 0.0, -1.0], np.float32), np.zeros(3, np.int64), cells, told, 7.0, calibration)
    assert found.time_s == 7.0
    np.testing.assert_allclose(found.score, [1 / (1 + math.exp(-3)), 1 / (1 + math.exp(-1))])


def test_no_cells_are_no_detections() -> None:
    nothing = np.zeros(0, np.int64)
    found = decode(
        np.zeros(0, np.float32), nothing, nothing, np.zeros((0, REGRESSION_SIZE), np.float32), 0.0, EVERYTHING
    )
    assert len(found) == 0
    assert found.center.shape == (0, 3)


@pytest.mark.parametrize("count", [1, 5, 60])
def test_what_remains_is_in_the_order_of_scores(count: int) -> None:
    random = np.random.default_rng(count)
    boxes = np.array([box(x) for x in random.uniform(-40, 80, count)])
    scores = random.uniform(0, 1, count)
    kept = suppressed(np.zeros(count, np.int64), scores, boxes)
    assert (np.diff(scores[kept]) <= 0).all()
    assert scores[kept[0]] == scores.max()
