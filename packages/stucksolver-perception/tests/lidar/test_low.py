"""How high a small thing is: scans of a LiDAR with the rig's drop-off, of boxes on a road."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scanner import seconds

from grids import sample
from stucksolver_perception.lidar.refinement.debris_height import BARE_M, NEAR_M, with_measured_heights
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections

GUESS_M = 0.26
"""What the network says of most small things."""


def box(x, y, length, width, height):
    return np.array([[x, y, height / 2, length, width, height, 0.3]])


def found(x, y, label="debris"):
    n = np.zeros(1)
    return Detections(
        0.5,
        n.astype(np.int64) + LABELS.index(label),
        n + 0.6,
        np.array([[x + 0.05, y - 0.05, GUESS_M / 2]]),
        np.array([[0.55, 0.45, GUESS_M]]),
        n,
        np.zeros((1, 2)),
    )


def measured(thing, detections, slope=0.0, seed=0):
    points = seconds([thing] * 10, seed)
    points[:, 2] += slope * points[:, 0]
    return with_measured_heights(detections, points)


@pytest.mark.parametrize(
    ("height_m", "x", "seed"), sample(itertools.product([0.08, 0.12, 0.2, 0.4], [5.0, 7.5, 9.0], range(3)), 12)
)
def test_low_height_of_near_object_is_highest_return(height_m, x, seed):
    """The height of a near object is that of its highest returns."""
    told = measured(box(x, 0.4, 0.45, 0.35, height_m), found(x, 0.4), seed=seed)
    # A ray may pass closely above the highest one that meets it.
    assert height_m - 0.08 < told.size[0, 2] < height_m + 0.04
    assert told.center[0, 2] == pytest.approx(told.size[0, 2] / 2, abs=0.03)
    assert told.size[0, :2].tolist() == [0.55, 0.45]
    assert told.height_known is not None and told.height_known.tolist() == [True]


@pytest.mark.parametrize("slope", [-0.06, 0.06])
def test_on_a_slope_as_well(slope):
    told = measured(box(7.0, 0.0, 0.45, 0.35, 0.12), found(7.0, 0.0), slope)
    assert told.size[0, 2] == pytest.approx(0.13, abs=0.05)


def test_somebody_beside_it_makes_it_no_lower():
    both = np.concatenate([box(7.0, 0.0, 0.45, 0.35, 0.12), box(7.2, 0.3, 0.5, 0.5, 1.7)])
    assert measured(both, found(7.0, 0.0)).size[0, 2] > 0.5


@pytest.mark.parametrize(
    "thing, detections",
    [
        (box(NEAR_M + 3.0, 0.0, 0.45, 0.35, 0.12), found(NEAR_M + 3.0, 0.0)),
        (box(7.0, 0.0, 0.45, 0.35, 0.12), found(7.0, 0.0, label="cone")),
        (box(30.0, 9.0, 4.0, 2.0, 1.5), found(7.0, 0.0)),
    ],
    ids=["far away", "of another kind", "nothing there"],
)
def test_otherwise_the_networks_word_stays(thing, detections):
    assert measured(thing, detections).size[0, 2] == GUESS_M


@pytest.mark.parametrize("x", [4.5, 5.5])
def test_nothing_is_where_only_the_road_returned_rays(x):
    assert len(measured(np.zeros((0, 7)), found(x, 0.2))) == 0
    assert len(measured(np.zeros((0, 7)), found(x, 0.2, "cone"))) == 1


def test_far_away_rays_may_pass_above_and_below_a_thing():
    assert len(measured(np.zeros((0, 7)), found(BARE_M + 1.0, 0.2))) == 1
    assert len(measured(box(5.5, 0.2, 0.45, 0.35, 0.08), found(5.5, 0.2))) == 1
