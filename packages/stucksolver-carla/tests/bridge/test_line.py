"""Paths without numpy: arc length, projection, and the speed from which all bounds ahead can be met."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver_bridge.path_line import PathLine

STRAIGHT = PathLine([(0.0, 0.0, 5.0), (10.0, 0.0, 5.0), (20.0, 0.0, 0.0)])
places = st.floats(-50, 50)


def test_a_path_needs_two_points_at_different_places():
    with pytest.raises(ValueError, match="two points"):
        PathLine([(1.0, 2.0, 3.0), (1.0, 2.0, 0.0)])
    with pytest.raises(ValueError, match="two points"):
        PathLine([])


@given(s=st.floats(-5, 25), beside=st.floats(-3, 3))
def test_project_point_beside_straight_path_keeps_arc_length(s, beside):
    assert STRAIGHT.project(s, beside, min(max(s, 0.0), 20.0)) == pytest.approx(max(s, 0.0))


@given(points=st.lists(st.tuples(places, places), min_size=2, max_size=8, unique=True), part=st.floats(0, 1))
def test_path_line_point_lies_at_its_arc_length(points, part):
    steps = [math.dist(a, b) for a, b in itertools.pairwise(points)]
    if min(steps) < 0.01:
        return
    line = PathLine([(x, y, 1.0) for x, y in points])
    assert line.length_m == pytest.approx(sum(steps))
    here, on = line.at(part * line.length_m), line.at(min(part * line.length_m + 0.01, line.length_m))
    assert math.dist(here[:2], on[:2]) <= 0.01 + 1e-6


@given(s=st.floats(0, 20))
def test_with_the_braking_given_every_bound_ahead_is_met(s):
    speed = STRAIGHT.bound_at(s, 3.0)
    assert speed <= 5.0
    assert speed**2 <= 2 * 3.0 * (20.0 - s) + 1e-9
