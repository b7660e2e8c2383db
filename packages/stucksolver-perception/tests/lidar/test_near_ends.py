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
def test_measured_ends_extend_vehicle_longer_than_detected(x_m: float, yaw: float) -> None:
    """A vehicle that is longer than its detection begins nearer."""
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


def test_measured_ends_skip_moving_and_adjacent_vehicles() -> None:
    """A vehicle that moves or is beside the LiDAR keeps its detected box."""
    turn = turn_of((11.0, 0.0, 1.15, *AMBULANCE, 0.0), (0.5, 3.0, 1.15, *AMBULANCE, 0.0))
    for item in (told(11.4, 0.0, (5.4, 2.2, 2.3), mps=3.0), told(0.9, 3.0, (5.4, 2.2, 2.3))):
        assert np.array_equal(with_measured_ends(item, turn, RIG).size, item.size)


def test_measured_ends_skip_hidden_ends_and_other_labels() -> None:
    """An end with too few returns stays where the network puts it."""
    hidden = turn_of((11.0, 0.0, 1.15, *AMBULANCE, 0.0), (5.0, 0.4, 1.2, 1.0, 1.9, 2.4, 0.0))
    one = told(11.5, 0.0, (5.4, 2.4, 2.3))
    assert np.array_equal(with_measured_ends(one, hidden, RIG).center, one.center)
    assert len(with_measured_ends(one.part(np.zeros(0, np.int64)), hidden, RIG)) == 0
    barrier = replace(one, label=np.array([LABELS.index("barrier")]))
    assert np.array_equal(with_measured_ends(barrier, turn_of((11.0, 0.0, 1.15, *AMBULANCE, 0.0)), RIG).size, one.size)
