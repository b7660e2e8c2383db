"""A person at a vehicle's side is believed only if rays came back from it."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scanner import RIG
from test_residual import named, tracked, turn

from grids import sample
from stucksolver_perception.lidar.refinement.false_pedestrians import drop_false_pedestrians
from stucksolver_perception.lidar.refinement.unexplained_returns import standing_returns
from stucksolver_perception.lidar_labels import LABELS

VAN = (10.5, -0.5, 5.9, 2.0, 2.6)
LEFT_M, FAR_M = VAN[1] + VAN[3] / 2, VAN[0] + VAN[2] / 2 - 1.0
PERSON = (0.5, 0.5, 1.75)


def left(x, y, *around, label="pedestrian", known=VAN, seed=0):
    standing = standing_returns(turn(*around, seed=seed), RIG)
    found = drop_false_pedestrians(named((x, y, *PERSON), label=label, score=0.5), standing, tracked(known))
    return [LABELS[item] for item in found.label]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("beside_m", [-0.3, 0.0, 0.15, 0.4])
def test_nobody_is_in_the_side_of_a_van(beside_m, seed):
    assert left(FAR_M, LEFT_M + beside_m, VAN, seed=seed) == []


@pytest.mark.parametrize(
    ("x", "beside_m", "seed"), sample(itertools.product([7.3, 10.0, FAR_M], [0.25, 0.3, 0.5], range(4)), 12)
)
def test_flanks_pedestrian_beside_van_is_kept(x, beside_m, seed):
    """A pedestrian beside a van is kept even if the box is a little nearer."""
    person = (x, LEFT_M + beside_m, *PERSON)
    for off_m in (-0.15, 0.0, 0.1):
        assert left(x, LEFT_M + beside_m + off_m, VAN, person, seed=seed) == ["pedestrian"]


def test_who_stands_before_the_rear_of_a_van_is_kept():
    x = VAN[0] - VAN[2] / 2 - 0.3
    assert left(x, VAN[1], VAN, (x, VAN[1], *PERSON)) == ["pedestrian"]


def test_of_other_things_and_away_from_vehicles_nothing_is_dropped():
    assert left(FAR_M, LEFT_M, VAN, label="cone") == ["cone"]
    assert left(FAR_M, LEFT_M + 0.6, VAN) == ["pedestrian"]
    assert left(FAR_M, LEFT_M, known=(30.0, *VAN[1:])) == ["pedestrian"]


def test_where_not_all_returns_are_known_nothing_is_dropped():
    for place in ((15.8, 0.0), (10.0, 2.9), (2.7, 0.0)):
        assert left(*place, known=(*place, 4.0, 1.8, 1.5)) == ["pedestrian"]


def test_without_vehicles_nothing_is_dropped():
    found = named((8.0, 0.0, *PERSON), label="pedestrian")
    assert drop_false_pedestrians(found, np.zeros((0, 3)), np.zeros((0, 8))) is found
