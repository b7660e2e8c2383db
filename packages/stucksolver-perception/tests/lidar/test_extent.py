"""How far barriers and cones reach: scans of a LiDAR with the rig's noise and drop-off, on a flat road."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scanner import RIG, seconds

from stucksolver_perception.lidar.refinement.barrier_extent import NEAR_M, with_measured_extents
from stucksolver_perception.lidar.refinement.barrier_rows import with_low_trucks_as_barriers
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections
from stucksolver_perception.tracking.association import suppress_duplicates

CONE_M = (0.34, 0.34, 0.63)
TRAILER_M = (2.4, 2.9, 3.5)
ROAD = np.zeros((0, 7))
PARTS = ("label", "score", "center", "size", "yaw", "velocity")


def box(x, y, size, yaw=0.0):
    return np.array([[x, y, size[2] / 2, *size, yaw]])


def named(label, x, y, size, yaw=0.0, speed=0.0):
    """One detection."""
    return Detections(
        0.5,
        np.array([LABELS.index(label)]),
        np.array([0.9]),
        np.array([[x, y, size[2] / 2]]),
        np.array([size], float),
        np.array([yaw]),
        np.array([[speed, 0.0]]),
    )


def measured(detections, *things, seed=0):
    return with_measured_extents(detections, seconds([np.concatenate(things)] * 10, seed), RIG)


def sides(found):
    """The right and the left edge of the only box (m)."""
    (length, width), yaw = found.size[0, :2], found.yaw[0]
    half = (abs(math.sin(yaw)) * length + abs(math.cos(yaw)) * width) / 2
    return found.center[0, 1] - half, found.center[0, 1] + half


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("x", [8.0, 14.0])
def test_a_barrier_seen_too_wide_ends_where_rays_pass_it(x, seed):
    told = measured(named("barrier", x, 0.2, (2.5, 4.3, 3.4)), box(x, 0.0, TRAILER_M), seed=seed)
    # What its front hides is not known to be free.
    shadow_m = 1.45 * (x + 1.2) / (x - 1.2)
    right, left = sides(told)
    assert left == pytest.approx(shadow_m, abs=0.15)
    assert -shadow_m - 0.15 < right < -1.4
    assert told.size[0, 2] == 3.4


def test_extent_barrier_alongside_gets_direction_of_its_sides():
    askew = math.radians(-11.0)
    told = measured(named("barrier", 3.0, -3.9, (2.6, 4.4, 3.4), 0.1), box(2.9, -4.0, TRAILER_M, askew))
    assert math.remainder(float(told.yaw[0]) - askew, math.pi / 2) == pytest.approx(0.0, abs=math.radians(4.0))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("x", "off"), [(6.0, 0.25), (10.0, -0.25), (12.0, 0.2), (16.0, 0.25)])
def test_a_cone_is_where_its_returns_are(x, off, seed):
    right, left = sides(measured(named("cone", x, 0.5 + off, (0.5, 0.5, 0.65)), box(x, 0.5, CONE_M), seed=seed))
    assert left == pytest.approx(0.71, abs=0.12)
    assert right == pytest.approx(0.29, abs=0.12)


@pytest.mark.parametrize(("other", "moves"), [("animal", True), ("debris", True), ("pedestrian", False)])
def test_extent_cone_with_second_label_stays_one_object(other, moves):
    """A cone that was also detected as an animal stays one object.

    It was found weakly as an animal at the same place. Measured separately, the animal was beside the cone.
    """
    size = (0.5, 0.5, 0.65)
    cone, twin = named("cone", 6.0, 0.95, size), named(other, 6.05, 0.95, size)
    both = Detections(0.5, *(np.concatenate([getattr(item, part) for item in (cone, twin)]) for part in PARTS))
    both = replace(both, score=np.array([0.7, 0.2]))
    told = measured(both, box(6.0, 0.5, CONE_M))
    assert told.center[0, 1] == pytest.approx(0.5, abs=0.12)
    assert bool(told.center[1, 1] < 0.75) is moves
    assert (len(suppress_duplicates(told)) == 1) is moves


def test_extent_cone_beside_trailer_keeps_its_width():
    """A cone beside a trailer is not as wide as both."""
    things = box(14.0, 0.0, TRAILER_M), box(14.0, 1.65, CONE_M)
    told = measured(named("cone", 14.0, 1.9, (0.6, 0.7, 1.1)), *things)
    right, left = sides(told)
    assert right > 1.3
    assert 1.75 < left < 2.05


@pytest.mark.parametrize(
    ("label", "x", "size"),
    [
        ("barrier", NEAR_M + 1.0, (2.5, 4.3, 3.4)),  # far away
        ("barrier", 8.0, (0.4, 4.3, 1.1)),  # the arm of a gate
        ("car", 8.0, (2.5, 4.3, 3.4)),
    ],
)
def test_nothing_else_is_measured(label, x, size):
    told = measured(named(label, x, 0.2, size), box(x, 0.0, TRAILER_M))
    assert told.size[0].tolist() == list(size)


def test_without_returns_from_beyond_a_box_stays_as_wide():
    points = seconds([box(10.0, 0.0, TRAILER_M)] * 10, 0)
    told = with_measured_extents(named("barrier", 10.0, 0.2, (2.5, 4.3, 3.4)), points[points[:, 2] > 0.3], RIG)
    assert sides(told)[1] > 2.2


def row(x, lowest, count=8):
    """Barriers end to end across the road, and the truck that the network sees there."""
    return np.concatenate([box(x, 1.2 * (k - count / 2), (0.4, 1.2, 1.06)) for k in range(count)]), named(
        "truck", x, 0.0, (2.4, 9.0, lowest)
    )


def low(detections, *things):
    return with_low_trucks_as_barriers(detections, seconds([np.concatenate(things)] * 2, 0), RIG)


def test_extent_truck_as_low_as_barrier_is_barriers():
    """A truck no higher than a barrier is a row of barriers."""
    barriers, truck = row(12.0, 2.7)
    told = low(truck, barriers)
    assert LABELS[told.label[0]] == "barrier"
    assert told.size[0, 2] == pytest.approx(1.0, abs=0.15)
    assert told.center[0, 2] == pytest.approx(0.5, abs=0.1)


def test_a_truck_stays_a_truck():
    truck = named("truck", 12.0, 0.0, (9.0, 2.4, 2.7))
    assert LABELS[low(truck, box(12.0, 0.0, (9.0, 2.4, 2.7))).label[0]] == "truck"
    # Its lowest part may be hidden, or all of it.
    assert LABELS[low(truck, box(12.0, 0.0, (9.0, 2.4, 2.7)), box(5.0, 0.0, (0.4, 3.0, 1.0))).label[0]] == "truck"
    assert LABELS[low(truck, ROAD).label[0]] == "truck"


def test_what_moves_is_no_row_of_barriers():
    barriers, _ = row(12.0, 2.7)
    moving = named("truck", 12.0, 0.0, (2.4, 9.0, 2.7), speed=3.0)
    assert LABELS[low(moving, barriers).label[0]] == "truck"
