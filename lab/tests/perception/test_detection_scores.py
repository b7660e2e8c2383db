from __future__ import annotations

import pytest
from made_up import PEDESTRIAN, detections, reals

from lab.perception.evaluation.metrics.detection import detection_scores


def test_labels_without_objects_do_not_count_in_the_mean() -> None:
    scores = detection_scores([detections((10.0, 0.0, 0.9))], [reals((10.0, 0.0))])
    assert scores.mean_average_precision == pytest.approx(1.0)
    assert scores.by_label["truck"].average_precision is None


def test_detection_score_error_of_1_5_m_counts_partly() -> None:
    """A box with an error of 1.5 m counts at two of the four match distances."""
    scores = detection_scores([detections((11.5, 0.0, 0.9))], [reals((10.0, 0.0))])
    assert scores.by_label["car"].at_distances == (0.0, 0.0, pytest.approx(1.0), pytest.approx(1.0))
    assert scores.by_label["car"].average_precision == pytest.approx(0.5)


def test_recall_and_precision_are_those_of_sure_detections() -> None:
    found = detections((10.0, 0.0, 0.9), (30.0, 0.0, 0.6), (50.0, 0.0, 0.4))
    scores = detection_scores([found], [reals((10.0, 0.0), (50.0, 0.0))])
    assert (scores.by_label["car"].recall, scores.by_label["car"].precision) == (0.5, 0.5)


def test_each_ring_has_its_own_objects() -> None:
    scores = detection_scores([detections((10.0, 0.0, 0.9))], [reals((10.0, 0.0), (50.0, 0.0), (90.0, 0.0))])
    objects = {ring: by_label["car"].objects for ring, by_label in scores.by_ring.items()}
    assert objects == {(0.0, 20.0): 1, (20.0, 40.0): 0, (40.0, 60.0): 1, (60.0, 80.0): 0}
    assert scores.by_label["car"].objects == 2


def test_the_mean_is_over_all_labels_that_there_are() -> None:
    scores = detection_scores(
        [detections((10.0, 0.0, 0.9))] * 2, [reals((10.0, 0.0)), reals((5.0, 9.0), label=PEDESTRIAN)]
    )
    assert scores.by_label["pedestrian"].average_precision == 0.0
    assert scores.mean_average_precision == pytest.approx((scores.by_label["car"].average_precision or 0.0) / 2.0)
