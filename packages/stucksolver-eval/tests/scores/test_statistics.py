"""Intervals and tests of paired differences."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver_eval.metrics.paired_statistics import bootstrap, compare_pairs

VALUES = st.lists(st.lists(st.floats(0, 100), min_size=1, max_size=3), min_size=1, max_size=12)


@given(VALUES)
def test_an_interval_lies_about_its_mean_and_within_the_values(groups: list[list[float]]) -> None:
    found = bootstrap(groups, resamples=500)
    every = [sum(group) / len(group) for group in groups]
    assert min(every) - 1e-9 <= found.low <= found.mean + 1e-9
    assert found.mean - 1e-9 <= found.high <= max(every) + 1e-9


def test_seeds_of_a_route_are_averaged_first() -> None:
    assert bootstrap([[0.0, 100.0], [100.0]], resamples=10).mean == 75.0


def test_no_difference_is_no_evidence() -> None:
    found = compare_pairs([[0.0]] * 10, resamples=200)
    assert (found.difference.mean, found.p) == (0.0, 1.0)


def test_the_same_gain_on_every_route_is_strong_evidence() -> None:
    found = compare_pairs([[1.0]] * 20)
    assert found.p < 0.001
    assert found.difference.low == 1.0


def test_three_routes_cannot_be_strong_evidence() -> None:
    # Of the eight ways to set three signs, two are as extreme.
    assert compare_pairs([[5.0], [5.0], [5.0]]).p == pytest.approx(0.25, abs=0.03)


def test_the_same_question_has_the_same_answer() -> None:
    groups = [[float(k % 7)] for k in range(30)]
    assert compare_pairs(groups) == compare_pairs(groups)


def test_nothing_cannot_be_averaged() -> None:
    with pytest.raises(ValueError, match="no route has a value"):
        bootstrap([])
