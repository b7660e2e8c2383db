"""Thinned grids keep every value, and the whole grid is every combination."""

from __future__ import annotations

import pytest

import grids

AXES = (["a", "b", "c", "d", "e"], [1, 2], [True, False])


@pytest.fixture(autouse=True)
def thinned(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(grids, "WHOLE", False)


def test_grid_each_value_uses_fewest_rows():
    """Each value occurs, in as few rows as possible."""
    rows = grids.each_value(*AXES)
    assert len(rows) == 5 and rows == grids.each_value(*AXES)
    assert [set(column) for column in zip(*rows, strict=True)] == [set(axis) for axis in AXES]


def test_sample_keeps_the_order_and_short_lists_whole():
    rows = grids.sample(range(100), 7)
    assert len(rows) == 7 and rows == sorted(rows) == grids.sample(range(100), 7)
    assert grids.sample(range(7), 7) == list(range(7))


def test_whole_grids_are_every_combination(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(grids, "WHOLE", True)
    assert len(grids.each_value(*AXES)) == 20 and len(grids.sample(range(100), 7)) == 100
