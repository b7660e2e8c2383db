from __future__ import annotations

import numpy as np
import pytest
from made_up import CAR, PEDESTRIAN, detections, reals

from lab.perception.evaluation.metrics.matching import ANY_LABEL, TruthObjects, match


def test_the_surer_of_two_detections_has_the_object() -> None:
    found = match([detections((10.0, 0.0, 0.4), (10.5, 0.0, 0.9))], [reals((10.2, 0.0))], CAR, 2.0)
    assert found.score.tolist() == [0.9, 0.4]
    assert found.right.tolist() == [True, False]


def test_a_detection_has_the_nearest_object_that_is_free() -> None:
    found = match([detections((10.0, 0.0, 0.9), (10.0, 0.0, 0.8))], [reals((11.0, 0.0), (10.1, 0.0))], CAR, 2.0)
    assert found.right.all()
    assert found.real.tolist() == [1, 0]


def test_an_object_of_another_label_is_not_found() -> None:
    found = match([detections((10.0, 0.0, 0.9))], [reals((10.0, 0.0), label=PEDESTRIAN)], CAR, 2.0)
    assert found.right.tolist() == [False]


def test_a_detection_farther_away_than_allowed_is_wrong() -> None:
    near = match([detections((11.9, 0.0, 0.9))], [reals((10.0, 0.0))], CAR, 2.0)
    far = match([detections((12.1, 0.0, 0.9))], [reals((10.0, 0.0))], CAR, 2.0)
    assert (near.right.tolist(), far.right.tolist()) == ([True], [False])


def test_matching_object_with_few_points_is_ignored() -> None:
    """An object with too few points is neither required nor a false positive when it is detected."""
    found = match([detections((10.0, 0.0, 0.9))], [reals((10.0, 0.0), counted=[False])], CAR, 2.0)
    assert len(found.score) == 0
    assert len(found.real_range_m) == 0


def test_matching_unlabeled_object_absorbs_detections_of_any_label() -> None:
    """An object without a label excuses a detection of any label over its whole length."""
    told = detections((12.5, 0.0, 0.9))
    long = reals((10.0, 0.0), label=ANY_LABEL)
    wide = TruthObjects(long.label, long.center, np.array([[6.0, 2.0, 1.0]]), *_rest(long))
    assert len(match([told], [wide], CAR, 2.0).score) == 0


def test_samples_are_not_mixed_and_the_order_is_by_score() -> None:
    found = match(
        [detections((10.0, 0.0, 0.3)), detections((20.0, 0.0, 0.7))], [reals((10.0, 0.0)), reals((10.0, 0.0))], CAR, 2.0
    )
    assert found.sample.tolist() == [1, 0]
    assert found.right.tolist() == [False, True]


@pytest.mark.parametrize(("ring", "objects", "told"), [((0.0, 20.0), 1, 1), ((20.0, 40.0), 1, 1)])
def test_a_right_detection_belongs_to_the_ring_of_its_object(
    ring: tuple[float, float], objects: int, told: int
) -> None:
    both = match([detections((20.5, 0.0, 0.9), (21.0, 9.0, 0.8))], [reals((19.5, 0.0), (21.0, 9.0))], CAR, 2.0)
    inside = both.between(*ring)
    assert (len(inside.real_range_m), len(inside.score)) == (objects, told)
    assert inside.right.all()


def _rest(one: TruthObjects) -> tuple[np.ndarray, ...]:  # type: ignore[type-arg]
    return one.yaw, one.velocity, one.counted, one.identity
