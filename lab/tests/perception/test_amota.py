from __future__ import annotations

import pytest
from made_up import frame

from lab.perception.evaluation.metrics.amota import amota, best_threshold


def test_perfect_tracking_is_one() -> None:
    assert amota([[frame({1: 0.0, 2: 9.0}, {7: 0.0, 8: 9.0})] * 3], 2.0) == pytest.approx(1.0)


def test_half_of_the_objects_is_half_of_the_levels() -> None:
    told = amota([[frame({1: 0.0, 2: 9.0}, {7: 0.0})] * 3], 2.0, levels=11)
    assert told == pytest.approx(0.5)


def test_amota_less_certain_false_tracks_cost_only_at_high_recall() -> None:
    """False tracks that are less certain than the true ones cost only at the recall that needs them."""
    unsure = [frame({1: 0.0}, {7: 0.0, 8: 50.0}, {7: 0.9, 8: 0.2})]
    sure = [frame({1: 0.0}, {7: 0.0, 8: 50.0}, {7: 0.2, 8: 0.9})]
    assert amota([unsure], 2.0) == pytest.approx(1.0)
    assert (amota([sure], 2.0) or 0.0) < 0.5


def test_amota_without_objects_is_undefined_without_tracks_zero() -> None:
    """Without objects, AMOTA is undefined; with objects and without true tracks, it is 0."""
    assert amota([[frame({}, {7: 0.0})]], 2.0) is None
    assert amota([[frame({1: 0.0}, {})]], 2.0) == 0.0


def test_the_best_threshold_leaves_false_tracks_out() -> None:
    frames = [frame({1: 0.0}, {7: 0.0, 8: 50.0}, {7: 0.9, 8: 0.2})]
    score, counts = best_threshold([frames], 2.0) or (0.0, None)
    assert counts is not None
    assert (score, counts.mota) == (0.9, 1.0)
