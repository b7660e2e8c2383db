from __future__ import annotations

import pytest
from made_up import frame

from lab.perception.evaluation.metrics.amota import amota, best_threshold


def test_perfect_tracking_is_one() -> None:
    assert amota([[frame({1: 0.0, 2: 9.0}, {7: 0.0, 8: 9.0})] * 3], 2.0) == pytest.approx(1.0)


def test_half_of_the_objects_is_half_of_the_levels() -> None:
    told = amota([[frame({1: 0.0, 2: 9.0}, {7: 0.0})] * 3], 2.0, levels=11)
    assert told == pytest.approx(0.5)


def test_false_tracks_that_are_less_sure_cost_only_where_recall_needs_them() -> None:
    unsure = [frame({1: 0.0}, {7: 0.0, 8: 50.0}, {7: 0.9, 8: 0.2})]
    sure = [frame({1: 0.0}, {7: 0.0, 8: 50.0}, {7: 0.2, 8: 0.9})]
    assert amota([unsure], 2.0) == pytest.approx(1.0)
    assert (amota([sure], 2.0) or 0.0) < 0.5


def test_without_objects_nothing_can_be_said_and_without_tracks_it_is_nothing() -> None:
    assert amota([[frame({}, {7: 0.0})]], 2.0) is None
    assert amota([[frame({1: 0.0}, {})]], 2.0) == 0.0


def test_the_best_threshold_leaves_false_tracks_out() -> None:
    frames = [frame({1: 0.0}, {7: 0.0, 8: 50.0}, {7: 0.9, 8: 0.2})]
    score, counts = best_threshold([frames], 2.0) or (0.0, None)
    assert counts is not None
    assert (score, counts.mota) == (0.9, 1.0)
