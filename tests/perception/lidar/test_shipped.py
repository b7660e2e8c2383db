"""The network that ships, in a world of boxes that it was not trained on."""

import numpy as np
import pytest
from tests.perception.lidar.scanner import TICK_S, seconds

from stucksolver.perception.labels import LABELS
from stucksolver.perception.lidar.detector import DATA, WEIGHTS, LidarDetector
from stucksolver.perception.measurements import Detections, Floats

if not (DATA / WEIGHTS).is_file():
    pytest.skip("no LiDAR network has been trained for this checkout", allow_module_level=True)

TICKS = 10
SURE = 0.5
CAR = np.array([0.0, 0.0, 0.75, 4.6, 1.9, 1.5, 0.0])


@pytest.fixture(scope="module")
def detector() -> LidarDetector:
    return LidarDetector()


def car(x_m: float, y_m: float, yaw_rad: float = 0.0) -> Floats:
    return CAR + np.array([x_m, y_m, 0, 0, 0, 0, yaw_rad])


def sure(found: Detections) -> Detections:
    return found.part(found.score > SURE)


@pytest.mark.parametrize(("x_m", "y_m", "yaw_rad"), [(10.0, 0.0, 0.0), (20.0, 3.5, 3.1), (15.0, -8.0, 1.5)])
def test_a_parked_car_is_found_where_it_stands(detector: LidarDetector, x_m: float, y_m: float, yaw_rad: float) -> None:
    found = sure(detector.detect(seconds([np.array([car(x_m, y_m, yaw_rad)])] * TICKS), 0.45))
    assert [LABELS[label] for label in found.label] == ["car"]
    assert np.hypot(found.center[0, 0] - x_m, found.center[0, 1] - y_m) < 0.7
    assert np.hypot(*found.velocity[0]) < 0.7


def test_what_drives_is_told_from_what_stands(detector: LidarDetector) -> None:
    ticks = [np.array([car(12.0, -3.5), car(8.0 + 8.0 * TICK_S * i, 3.5)]) for i in range(TICKS)]
    found = sure(detector.detect(seconds(ticks), 0.45))
    by_side = {float(np.sign(y)): velocity for y, velocity in zip(found.center[:, 1], found.velocity, strict=True)}
    assert by_side[1.0][0] == pytest.approx(8.0, abs=1.5)
    assert by_side[-1.0][0] == pytest.approx(0.0, abs=0.7)


def test_an_empty_road_is_empty(detector: LidarDetector) -> None:
    assert len(sure(detector.detect(seconds([np.zeros((0, 7))] * TICKS), 0.45))) == 0


def test_the_same_points_give_the_same_boxes(detector: LidarDetector) -> None:
    points = seconds([np.array([car(10.0, 0.0)])] * TICKS)
    first, second = detector.detect(points, 0.45), LidarDetector().detect(points, 0.45)
    np.testing.assert_array_equal(first.center, second.center)
    np.testing.assert_array_equal(first.score, second.score)
