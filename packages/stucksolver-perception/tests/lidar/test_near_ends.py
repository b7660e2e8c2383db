"""Near ends of standing vehicles, as a simulated LiDAR sees them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scanner import RIG, seconds

from stucksolver_perception.lidar.refinement.vehicle_ends import with_measured_ends
from stucksolver_perception.lidar.sweeps import RECENT_S
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections, Floats, Singles

AMBULANCE = (6.4, 2.4, 2.3)


def turn_of(*boxes: tuple[float, ...]) -> Singles:
    points = seconds([np.array(boxes)] * 4)
    return points[points[:, 4] <= RECENT_S]


def told(
    x_m: float, y_m: float, size: tuple[float, float, float], yaw: float = 0.0, label: str = "truck", mps: float = 0.0
) -> Detections:
    return Detections(
        time_s=0.0,
        label=np.array([LABELS.index(label)]),
        score=np.ones(1),
        center=np.array([[x_m, y_m, size[2] / 2]]),
        size=np.array([size]),
        yaw=np.array([yaw]),
        velocity=np.array([[mps, 0.0]]),
    )


def ends_m(found: Detections) -> Floats:
    """Both ends along the vehicle's x axis (m), the nearer one first."""
    ends = found.center[0, 0] + np.array([-0.5, 0.5]) * found.size[0, 0] * np.cos(found.yaw[0])
    return ends[np.argsort(np.abs(ends))]


@pytest.mark.parametrize("yaw", [0.0, np.pi])
@pytest.mark.parametrize("x_m", [-12.0, 11.0])
def test_a_vehicle_that_is_longer_than_the_network_says_begins_nearer(x_m: float, yaw: float) -> None:
    turn = turn_of((x_m, 0.3, 1.15, *AMBULANCE, 0.0))
    far_end = np.sign(x_m) * (abs(x_m) + 3.0)
    shorter = told(x_m + np.sign(x_m) * 0.3, 0.3, (5.4, 2.2, 2.3), yaw)
    found = ends_m(with_measured_ends(shorter, turn, RIG))
    assert abs(found[0]) == pytest.approx(abs(x_m) - 3.2, abs=0.1)
    assert found[1] == pytest.approx(far_end, abs=0.05)
    assert with_measured_ends(shorter, turn, RIG).yaw[0] == yaw


def test_a_box_that_begins_too_near_is_cut() -> None:
    turn = turn_of((11.0, 0.0, 1.15, *AMBULANCE, 0.0))
    found = ends_m(with_measured_ends(told(10.6, 0.0, (7.2, 2.2, 2.3)), turn, RIG))
    assert found[0] == pytest.approx(7.8, abs=0.1)


def test_a_person_before_the_corner_is_not_its_end() -> None:
    """The person has a box of its own, and is nearer than the vehicle."""
    turn = turn_of((11.0, 0.0, 1.15, *AMBULANCE, 0.0), (7.2, -0.9, 0.9, 0.4, 0.5, 1.8, 0.0))
    found = ends_m(with_measured_ends(told(11.0, 0.0, AMBULANCE), turn, RIG))
    assert found[0] == pytest.approx(7.8, abs=0.1)


def test_what_moves_or_is_beside_the_lidar_stays_as_it_was_found() -> None:
    turn = turn_of((11.0, 0.0, 1.15, *AMBULANCE, 0.0), (0.5, 3.0, 1.15, *AMBULANCE, 0.0))
    for item in (told(11.4, 0.0, (5.4, 2.2, 2.3), mps=3.0), told(0.9, 3.0, (5.4, 2.2, 2.3))):
        assert np.array_equal(with_measured_ends(item, turn, RIG).size, item.size)


def test_an_end_of_which_too_little_is_seen_stays_where_the_network_says() -> None:
    hidden = turn_of((11.0, 0.0, 1.15, *AMBULANCE, 0.0), (5.0, 0.4, 1.2, 1.0, 1.9, 2.4, 0.0))
    one = told(11.5, 0.0, (5.4, 2.4, 2.3))
    assert np.array_equal(with_measured_ends(one, hidden, RIG).center, one.center)
    assert len(with_measured_ends(one.part(np.zeros(0, np.int64)), hidden, RIG)) == 0
    barrier = replace(one, label=np.array([LABELS.index("barrier")]))
    assert np.array_equal(with_measured_ends(barrier, turn_of((11.0, 0.0, 1.15, *AMBULANCE, 0.0)), RIG).size, one.size)
