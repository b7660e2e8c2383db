from __future__ import annotations

import numpy as np
import pytest

from lab.perception.evaluation.metrics.confusion import confusion
from lab.perception.evaluation.metrics.latency import latency
from lab.perception.evaluation.metrics.range_recall import recall_by_range
from lab.perception.evaluation.metrics.rectangles import matched, overlaps


def test_what_was_not_answered_lowers_recall_and_not_accuracy() -> None:
    matrix = confusion(("red", "green"), [("red", "red"), ("red", None), ("green", "red")])
    assert (matrix.accuracy, matrix.answered) == (0.5, pytest.approx(2.0 / 3.0))
    assert (matrix.recall("red"), matrix.precision("red"), matrix.precision("green")) == (0.5, 0.5, None)


def test_a_name_that_is_not_asked_for_is_refused() -> None:
    with pytest.raises(ValueError, match="blue"):
        confusion(("red",), [("red", "blue")])


def test_recall_is_told_bin_by_bin() -> None:
    bins = recall_by_range(np.array([5.0, 24.9, 25.0, 60.0]), np.array([True, False, True, True]), 25.0, 50.0)
    assert [(bin.objects, bin.found, bin.recall) for bin in bins] == [(2, 1, 0.5), (1, 1, 1.0)]


def test_rectangles_overlap_as_their_areas_do() -> None:
    one, other = np.array([[0.0, 0.0, 2.0, 2.0]]), np.array([[1.0, 0.0, 3.0, 2.0], [5.0, 5.0, 6.0, 6.0]])
    assert overlaps(one, other).tolist() == [[pytest.approx(1.0 / 3.0), 0.0]]


def test_a_wanted_rectangle_is_found_once() -> None:
    found = np.array([[0.0, 0.0, 2.0, 2.0], [0.1, 0.0, 2.0, 2.0]])
    right, taken = matched(found, np.array([0.5, 0.9]), np.array([[0.0, 0.0, 2.0, 2.0]]), 0.5)
    assert (right.tolist(), taken.tolist()) == ([False, True], [True])


def test_latency_is_that_of_all_runs() -> None:
    found = latency([1.0, 2.0, 3.0, 100.0])
    assert found is not None
    assert (found.runs, found.median_ms, found.worst_ms) == (4, 2.5, 100.0)
    assert latency([]) is None
