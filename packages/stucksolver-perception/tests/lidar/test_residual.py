"""What stands ahead and has no name: scans of a LiDAR with the rig's noise and drop-off, on a flat road."""

from __future__ import annotations

import numpy as np
import pytest
from scanner import RIG, seconds

from stucksolver_perception.lidar.refinement.unexplained_returns import AHEAD_M, standing_returns, with_unexplained
from stucksolver_perception.lidar.sweeps import RECENT_S
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections

NOTHING = np.zeros((0, 8))
PERSON = (0.5, 0.5, 1.75)


def boxes(*ones):
    """(n, 7) of (x, y, length, width, height), standing on the road."""
    return np.array([(x, y, h / 2, length, w, h, 0.0) for x, y, length, w, h in ones]).reshape(-1, 7)


def turn(*ones, seed=0):
    points = seconds([boxes(*ones)] * 3, seed)
    return points[points[:, 4] <= RECENT_S]


def named(*ones, label="car", score=0.9):
    n, b = len(ones), boxes(*ones)
    return Detections(
        0.1,
        np.full(n, LABELS.index(label)),
        np.full(n, score),
        b[:, :3],
        b[:, 3:6],
        b[:, 6],
        np.zeros((n, 2)),
    )


def tracked(*ones, speed=0.0):
    """(n, 8): the same boxes with a speed."""
    return np.column_stack([boxes(*ones), np.full(len(ones), speed)])


def added(points, detections=None, known=NOTHING):
    detections = named() if detections is None else detections
    found = with_unexplained(detections, standing_returns(points, RIG), known)
    before = len(detections)
    assert np.array_equal(found.center[:before], detections.center), "the network's own come first, unchanged"
    return [
        (LABELS[found.label[k]], *found.center[k, :2].round(1).tolist(), *found.size[k].round(1).tolist())
        for k in range(before, len(found))
    ]


@pytest.mark.parametrize("seed", range(5))
def test_an_empty_road_has_no_obstacle(seed):
    assert added(turn(seed=seed)) == []


@pytest.mark.parametrize("x", [3.5, 6.0, 10.0, AHEAD_M - 1.0])
@pytest.mark.parametrize("y", [-1.5, 0.0, 2.0])
def test_a_person_that_the_network_missed_is_an_obstacle(x, y):
    ((label, at_x, at_y, length, width, height),) = added(turn((x, y, *PERSON)))
    assert label == "pedestrian"
    # Of most places only the near side is seen.
    assert abs(at_x - x) < 0.35 and abs(at_y - y) < 0.2
    assert length <= 0.7 and width <= 0.7 and height <= 1.8


def test_residual_pedestrians_in_row_are_obstacle_of_their_width():
    """Pedestrians in a row are an obstacle as wide as they are."""
    row = [(8.0, y, *PERSON) for y in np.arange(-1.5, 1.6, 0.6)]
    found = added(turn(*row))
    assert found
    assert min(y - width / 2 for _, _, y, _, width, _ in found) < -1.5
    assert max(y + width / 2 for _, _, y, _, width, _ in found) > 1.5


def test_a_thin_bar_across_the_road_is_a_barrier():
    gate = np.array([[9.0, 0.0, 1.0, 0.1, 5.0, 0.12, 0.0]])
    points = seconds([gate] * 3)
    found = added(points[points[:, 4] <= RECENT_S])
    assert {item[0] for item in found} == {"barrier"}
    assert max(y + width / 2 for _, _, y, _, width, _ in found) > 2.0


def test_residual_detected_or_tracked_vehicle_is_explained():
    """A detected vehicle is explained, and so is a tracked one that the network missed once."""
    car = (9.0, 0.3, 4.4, 1.8, 1.5)
    points = turn(car)
    assert added(points) != []
    assert added(points, named(car)) == []
    assert added(points, named(car, score=0.1)) != [], "a guess explains nothing"
    assert added(points, known=tracked(car)) == []


def test_a_person_beside_a_named_car_is_still_seen():
    car = (9.0, 0.0, 4.4, 1.8, 1.5)
    ((label, _, y, *_),) = added(turn(car, (7.0, -2.0, *PERSON)), named(car))
    assert label == "pedestrian" and abs(y + 2.0) < 0.3


def test_residual_curbs_signs_and_lateral_objects_are_ignored():
    """Curbs, overhead signs and objects to the side or behind are no obstacles."""
    kerb = (10.0, 2.4, 12.0, 0.6, 0.2)
    assert added(turn(kerb)) == []
    points = seconds([np.array([[10.0, 0.0, 2.6, 0.1, 5.0, 0.8, 0.0]])] * 3)
    assert added(points[points[:, 4] <= RECENT_S]) == []
    assert added(turn((8.0, 4.0, *PERSON))) == []
    assert added(turn((-6.0, 0.0, *PERSON))) == []


@pytest.mark.parametrize("bend", [-0.2, -0.16, 0.16, 0.2])
@pytest.mark.parametrize("begins_m", [3.0, 6.0, 10.0])
def test_residual_change_of_slope_is_no_obstacle(bend, begins_m):
    """A road that begins to rise or fall is no obstacle, and a pedestrian on it is one.

    Steeper than any road that `ground_heights` expects.
    """
    for ones in ((), ((12.0, 0.5, *PERSON),)):
        points = turn(*ones)
        points[:, 2] += bend * np.maximum(0.0, points[:, 0] - begins_m)
        assert [item[0] for item in added(points)] == ["pedestrian"] * len(ones)


@pytest.mark.parametrize("deep_m", [0.37, 0.8, 2.0])
@pytest.mark.parametrize("edge_m", [-2.0, -1.2, 1.6])
def test_an_embankment_does_not_make_the_road_stand_up(deep_m, edge_m):
    for ones in ((), ((8.0, 0.0, *PERSON),)):
        points = turn(*ones)
        beside = (points[:, 1] < edge_m) if edge_m < 0 else (points[:, 1] > edge_m)
        points[beside, 2] -= deep_m
        assert [item[0] for item in added(points)] == ["pedestrian"] * len(ones)


def test_no_points_and_no_detections_are_fine():
    assert added(np.zeros((0, 5), np.float32)) == []


def test_residual_rear_of_moving_car_is_no_obstacle():
    """The rear of a car that drives on is no obstacle.

    The box of a car at 9 m/s is ahead of the returns of a whole turn by a meter or more.
    """
    car, ahead = (10.0, 1.0, 4.5, 1.9, 1.5), (11.5, 1.0, 4.5, 1.9, 1.5)
    assert added(turn(car), known=tracked(ahead)) != []
    assert added(turn(car), known=tracked(ahead, speed=9.0)) == []
    found = named(ahead)
    found.velocity[:] = (9.0, 0.0)
    assert added(turn(car), found) == []


def test_residual_rear_of_moving_bus_is_no_pedestrian():
    """The rear of a bus that drives ahead is no pedestrian.

    Its box is too short. Close behind a stopped bus there may be a pedestrian.
    """
    bus, told = (13.5, 0.0, 10.9, 2.4, 3.1), (13.6, 0.0, 8.8, 2.6, 3.1)
    assert added(turn(bus), known=tracked(told, speed=0.5)) != []
    assert added(turn(bus), known=tracked(told, speed=2.0)) == []


def test_residual_pedestrian_behind_stopped_car_is_obstacle():
    """A pedestrian who walks close behind a stopped car is an obstacle."""
    car, person = (12.0, 0.0, 4.5, 1.9, 1.5), (8.6, 0.0, *PERSON)
    assert [item[0] for item in added(turn(car, person), known=tracked(car))] == ["pedestrian"]
