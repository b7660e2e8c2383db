"""What counts in scores, and where it is."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lab.perception.evaluation.scoring.samples import label_of, points_in, reals_of, visible_rectangles
from stucksolver.scene import ObjectKind
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import LidarSweep
from stucksolver_perception.recording import BOX_COLUMNS, KINDS, Recorded, Truth

CAR_BOX = (4.0, 2.0, 1.5)


def tick(x: float, y: float, ego: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Recorded:
    """A car with speed 5 m/s along the local x, seen from an ego at (x, y, yaw)."""
    pose = np.array([ego[0], ego[1], 0.0, ego[2], 0.0, 0.0, 0.0, 0.0, 0.0])
    boxes = np.array([[x, y, 0.75, 0.0, *CAR_BOX, 5.0, 0.0]])
    assert boxes.shape[1] == len(BOX_COLUMNS)
    kind = np.array([KINDS.index(ObjectKind.CAR)])
    truth = Truth(
        np.array([70000]), kind, boxes, np.array([0]), np.array([0]), np.array([-1]), np.array([-1]), ("vehicle.x",)
    )
    mask = np.zeros((20, 20), np.uint16)
    mask[5:10, 2:9] = 70000 % 65536
    mask[15, 15] = 12
    sweep = LidarSweep(1.0, np.zeros((0, 4), np.float32))
    return Recorded(1.0, pose, sweep, np.zeros(7), np.zeros(3), 0.0, truth, None, None, mask)


def at(*places: tuple[float, float, float], age_s: float = 0.0) -> np.ndarray:  # type: ignore[type-arg]
    return np.array([(*place, 0.5, age_s) for place in places], np.float32).reshape(-1, 5)


def test_sample_object_counts_from_three_current_points() -> None:
    """An object counts when it has at least three points of the last LiDAR turn."""
    inside = [(10.0, 0.0, 0.5), (11.0, 0.5, 1.0), (9.0, -0.5, 1.0)]
    assert reals_of(tick(10.0, 0.0), at(*inside)).counted.tolist() == [True]
    assert reals_of(tick(10.0, 0.0), at(*inside[:2])).counted.tolist() == [False]
    assert reals_of(tick(10.0, 0.0), at(*inside, age_s=0.3)).counted.tolist() == [False]


def test_boxes_and_velocities_are_turned_into_the_vehicle_frame() -> None:
    found = reals_of(tick(10.0, 0.0, ego=(10.0, -20.0, math.pi / 2.0)), at())
    assert found.center[0].tolist() == pytest.approx([20.0, 0.0, 0.75], abs=1e-9)
    assert found.velocity[0].tolist() == pytest.approx([0.0, -5.0], abs=1e-9)
    assert found.yaw[0] == pytest.approx(-math.pi / 2.0)


def test_points_are_counted_in_the_turned_box() -> None:
    box = np.array([[0.0, 0.0, 0.0, 4.0, 1.0, 2.0, math.pi / 2.0]])
    points = np.array([[0.0, 1.9, 0.0], [1.9, 0.0, 0.0], [0.0, 0.0, 1.1]], np.float32)
    assert points_in(box, points).tolist() == [1]


def test_label_long_emergency_vehicle_is_truck_prop_is_none() -> None:
    """A long emergency vehicle is a truck, a short one a car, and a prop has no label."""
    assert LABELS[label_of(ObjectKind.EMERGENCY, 8.0)] == "truck"
    assert LABELS[label_of(ObjectKind.EMERGENCY, 5.0)] == "car"
    assert label_of(ObjectKind.PROP, 1.0) == -1


def test_who_shows_too_few_pixels_is_not_seen() -> None:
    assert visible_rectangles(tick(10.0, 0.0)) == {70000 % 65536: (2, 5, 9, 10)}
