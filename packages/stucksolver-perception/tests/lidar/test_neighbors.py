"""People who stand close together: scans of a LiDAR with the rig's noise and drop-off, on a flat road."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from test_residual import NOTHING, named, tracked, turn

from grids import sample
from stucksolver_perception.lidar.refinement.close_pedestrians import add_close_pedestrians
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections

PERSON, WIDE = (0.4, 0.4, 1.75), (0.5, 0.5, 1.75)


def added(points, detections, known=NOTHING):
    found = add_close_pedestrians(detections, points, known)
    before = len(detections)
    assert np.array_equal(found.center[:before], detections.center), "the network's own come first, unchanged"
    assert all(LABELS[label] == "pedestrian" for label in found.label[before:])
    return found.center[before:, :2]


def person(x, y, vx=0.0) -> Detections:
    found = named((x, y, *PERSON), label="pedestrian")
    found.velocity[:, 0] = vx
    return found


BESIDE = itertools.product([(2.8, -1.1), (3.2, 0.0), (5.0, -0.5)], [(-0.35, -0.4), (0.0, -0.55), (0.1, 0.6)], range(4))


@pytest.mark.parametrize(("place", "aside", "seed"), sample(BESIDE, 12))
def test_neighbors_second_pedestrian_beside_detected_is_added(place, aside, seed):
    """A pedestrian half a meter beside the detected one is another pedestrian."""
    x, y = place
    other = (x + aside[0], y + aside[1])
    # As in the drives: the one box is a little off its person, towards the other.
    box = person(other[0] - aside[0] * 0.2, other[1] - aside[1] * 0.2)
    (at,) = added(turn((x, y, *PERSON), (*other, *PERSON), seed=seed), box)
    assert np.hypot(at[0] - x, at[1] - y) < 0.35
    assert np.hypot(at[0] - other[0], at[1] - other[1]) > 0.35


def test_who_leans_on_the_bumper_s_corner_is_seen():
    """The nose ends 2.45 m ahead and 0.92 m aside."""
    (at,) = added(turn((2.55, -1.15, *PERSON), (2.2, -1.6, *PERSON)), person(2.3, -1.5))
    assert np.hypot(at[0] - 2.55, at[1] + 1.15) < 0.3


ALONE = itertools.product([(2.8, -1.2), (3.2, 0.3), (5.5, 1.5)], [(0.0, 0.0), (0.12, 0.0), (0.0, -0.12)], range(4))


@pytest.mark.parametrize(("place", "off", "seed"), sample(ALONE, 12))
def test_one_person_is_one_person(place, off, seed):
    x, y = place
    for size in (PERSON, WIDE):
        points = turn((x, y, *size), seed=seed)
        assert len(added(points, person(x + off[0], y + off[1]))) == 0


def test_who_walks_ahead_of_an_old_box_is_not_two():
    assert len(added(turn((3.6, 0.0, *PERSON)), person(3.3, 0.0, vx=1.4))) == 0
    assert len(added(turn((3.85, 0.0, *PERSON)), person(3.3, 0.0))) == 1


def test_a_car_beside_a_person_is_no_person():
    car = (4.5, 1.7, 4.4, 1.8, 1.5)
    points = turn((3.2, 0.2, *PERSON), car)
    assert len(added(points, person(3.2, 0.2))) > 0, "somebody or something stands there"
    assert len(added(points, person(3.2, 0.2), tracked(car))) == 0


def test_without_a_person_nothing_is_added():
    points = turn((3.2, 0.0, *PERSON))
    assert len(added(points, named())) == 0
    assert len(added(np.zeros((0, 5), np.float32), person(3.0, 0.0))) == 0
