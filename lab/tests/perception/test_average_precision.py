from __future__ import annotations

import numpy as np
import pytest

from lab.perception.evaluation.metrics.average_precision import average_precision


def test_all_found_and_none_wrong_is_one() -> None:
    assert average_precision(np.ones(7, np.bool_), 7) == pytest.approx(1.0)


def test_nothing_found_is_nothing() -> None:
    assert average_precision(np.zeros(0, np.bool_), 4) == 0.0
    assert average_precision(np.zeros(3, np.bool_), 4) == 0.0


def test_without_objects_nothing_can_be_said() -> None:
    assert average_precision(np.zeros(2, np.bool_), 0) is None


def test_average_precision_half_recall_counts_levels_below_half() -> None:
    """When half of the objects are found with precision 1, the levels of recall up to 0.5 count."""
    # 40 of the 90 levels above 0.1 are reached, each with precision 1, of which 0.1 is taken off as from the whole.
    assert average_precision(np.ones(5, np.bool_), 10) == pytest.approx(40.0 / 90.0)


def test_average_precision_early_false_positives_cost_more() -> None:
    """A false positive costs more before the true positives than after the first of them."""
    before = average_precision(np.array([False, True, True]), 2)
    after = average_precision(np.array([True, True, False]), 2)
    assert before is not None and after is not None
    # As in nuScenes, precision at full recall is that after the wrong one which follows the last right one.
    assert after == pytest.approx(1.0, abs=5e-3)
    assert before < after


def test_precision_of_a_half_throughout_is_four_ninths() -> None:
    right = np.tile([False, True], 500)
    assert average_precision(right, 500) == pytest.approx((0.5 - 0.1) / 0.9, abs=2e-3)
