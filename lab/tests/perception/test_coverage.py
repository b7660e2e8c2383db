"""Who of a group is noticed, by hand."""

from __future__ import annotations

import numpy as np

from lab.perception.evaluation.metrics.matching import TruthObjects
from lab.perception.evaluation.metrics.pedestrian_recall import PedestrianRecall, coverage
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections

PERSON, CAR = LABELS.index("pedestrian"), LABELS.index("car")


def people(*places, label=PERSON, counted=True):
    n = len(places)
    return TruthObjects(
        label=np.full(n, label),
        center=np.array([(x, y, 0.9) for x, y in places]).reshape(-1, 3),
        size=np.tile((0.5, 0.5, 1.8), (n, 1)),
        yaw=np.zeros(n),
        velocity=np.zeros((n, 2)),
        counted=np.full(n, counted),
        identity=np.arange(n),
    )


def boxes(*ones):
    """(x, y, length, width, yaw, label, score)."""
    n, b = len(ones), np.array(ones, float).reshape(-1, 7)
    center, size = np.column_stack([b[:, :2], np.full(n, 0.9)]), np.column_stack([b[:, 2:4], np.full(n, 1.8)])
    return Detections(0.0, b[:, 5].astype(np.int64), b[:, 6], center, size, b[:, 4], np.zeros((n, 2)))


def test_a_group_taken_for_a_car_is_noticed():
    group = people((10.0, 1.0), (10.0, 1.5), (10.6, 1.2))
    assert coverage(boxes((10.2, 1.2, 2.0, 1.5, 0.0, CAR, 0.8)), group) == PedestrianRecall(3, 3, 3, 3)


def test_coverage_box_covers_own_place_and_weak_box_none():
    """A box does not cover a pedestrian beside it, and a box with a low score covers no pedestrian."""
    group = people((10.0, 0.0), (10.0, 0.6), (10.0, 1.2))
    assert coverage(boxes((10.0, 0.0, 0.5, 0.5, 0.3, PERSON, 0.9)), group) == PedestrianRecall(3, 2, 3, 2)
    assert coverage(boxes((10.0, 0.0, 0.5, 0.5, 0.3, PERSON, 0.3)), group) == PedestrianRecall(3, 0, 3, 0)


def test_coverage_counts_only_near_pedestrians_with_returns():
    """Only near pedestrians with LiDAR returns count, and only those in front count as ahead."""
    found = boxes((10.0, 8.0, 0.5, 0.5, 0.0, PERSON, 0.9))
    assert coverage(found, people((10.0, 8.0), (-5.0, 0.0), (25.0, 0.0))) == PedestrianRecall(2, 1, 0, 0)
    assert coverage(found, people((10.0, 8.0), counted=False)) == PedestrianRecall()
    assert coverage(found, people((10.0, 8.0), label=CAR)) == PedestrianRecall()
    assert coverage(boxes(), people()) == PedestrianRecall()
