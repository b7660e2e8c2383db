from __future__ import annotations

import math

import numpy as np
import pytest
from tests.tracking.scenes import STEP_S, detections, follow, nothing, pose

from stucksolver_perception.free_space import AZIMUTHS, CELL_M, FreeSpace
from stucksolver_perception.rig import load_rig
from stucksolver_perception.tracking import ObjectTracker

LIDAR = load_rig().lidar


def everywhere(is_free, nearest_m=math.inf):
    cells = np.full((AZIMUTHS, int(LIDAR.range_m / CELL_M)), is_free)
    return FreeSpace(cells, np.full(AZIMUTHS, nearest_m), np.zeros(AZIMUTHS), (0.0, 0.0))


def kept_for_s(space):
    tracker = ObjectTracker()
    follow(tracker, lambda _: ((15.0, 0.0), (0.0, 0.0)), 3.0, np.random.default_rng(0))
    for k in range(60):
        told = tracker.update(nothing(3.0 + k * STEP_S), pose(3.0 + k * STEP_S), space)
        if not told:
            return k * STEP_S
        assert told[0].hidden == (space.blocked_m[0] < 10.0)
    return math.inf


def test_who_was_not_found_is_kept_behind_what_is_nearer():
    assert kept_for_s(everywhere(False, nearest_m=8.0)) == math.inf


def test_tracker_missed_object_in_free_space_ends_soon():
    """An object that was missed is soon gone where its place is free space."""
    assert kept_for_s(everywhere(True)) <= 0.8


def test_tracker_missed_object_in_wall_fades_within_3_s():
    """An object in a wall that the detector misses fades within seconds."""
    assert 0.8 < kept_for_s(everywhere(False)) < 3.0
    assert 0.8 < kept_for_s(everywhere(False, nearest_m=14.0)) < 3.0


def test_what_lies_below_the_lowest_beam_is_remembered():
    tracker = ObjectTracker()
    cone = {"label": 5, "size": (0.4, 0.4, 0.7)}
    follow(tracker, lambda _: ((6.0, 0.0), (0.0, 0.0)), 3.0, np.random.default_rng(1), **cone)
    for k in range(50):
        told = tracker.update(nothing(3.0 + k * STEP_S), pose(3.0 + k * STEP_S, x=4.5))
    assert len(told) == 1


@pytest.mark.integration
def test_tracker_object_before_stopped_ego_is_kept():
    """An object in front of the ego is kept while the ego is stopped.

    Rays pass above it, and it was not observed to leave.
    """
    tracker, bag = ObjectTracker(), {"label": 7, "size": (0.5, 0.4, 0.15)}
    follow(tracker, lambda _: ((9.0, 0.0), (0.0, 0.0)), 3.0, np.random.default_rng(1), **bag)
    for k in range(600):
        told = tracker.update(nothing(3.0 + k * STEP_S), pose(3.0 + k * STEP_S, x=5.6))
    assert len(told) == 1
    for k in range(600, 920):
        told = tracker.update(nothing(3.0 + k * STEP_S), pose(3.0 + k * STEP_S, x=8.0, speed=0.3))
    assert told == ()


def test_what_was_hardly_found_before_the_nose_is_forgotten():
    tracker, ghost = ObjectTracker(), {"label": 7, "size": (0.7, 0.7, 0.2), "score": 0.45}
    follow(tracker, lambda _: ((9.0, 0.0), (0.0, 0.0)), 0.8, np.random.default_rng(1), **ghost)
    for k in range(600):
        told = tracker.update(nothing(0.8 + k * STEP_S), pose(0.8 + k * STEP_S, x=5.6))
    assert told == ()


def test_who_is_beyond_range_is_remembered_for_a_while_only():
    tracker = ObjectTracker()
    follow(tracker, lambda _: ((30.0, 5.0), (0.0, 0.0)), 3.0, np.random.default_rng(2))
    lasted = 0
    for k in range(400):
        if tracker.update(nothing(3.0 + k * STEP_S), pose(3.0 + k * STEP_S, x=-60.0)):
            lasted = k * STEP_S
    assert 25.0 < lasted < 31.0


CONE = {"label": 5, "size": (0.4, 0.4, 0.7)}


def hidden_cone_after(seconds, speed):
    """A cone that passes below the lowest beam, after so many seconds beside the vehicle."""
    tracker = ObjectTracker()
    follow(tracker, lambda _: ((6.0, 0.0), (0.0, 0.0)), 3.0, np.random.default_rng(1), **CONE)
    for k in range(round(seconds / STEP_S)):
        told = tracker.update(nothing(3.0 + k * STEP_S), pose(3.0 + k * STEP_S, x=4.5, speed=speed))
    return math.sqrt(told[0].covariance[0, 0])


def test_tracker_object_beside_stopped_vehicle_stays_in_place():
    """An object beside a stopped vehicle stays where it was."""
    assert hidden_cone_after(20.0, speed=0.0) < 0.1
    # While the vehicle moves, its own place becomes less certain, but the thing does not set off.
    assert 0.1 < hidden_cone_after(20.0, speed=1.0) < 0.3


def test_tracker_intermittent_cone_keeps_id_below_rays():
    """A cone found only now and then keeps its id though rays pass above it."""
    tracker, rng, ids = ObjectTracker(), np.random.default_rng(3), set()
    follow(tracker, lambda _: ((15.0, 0.0), (0.0, 0.0)), 3.0, rng, **CONE)
    for k in range(100):
        at = 3.0 + k * STEP_S
        told = tracker.update(
            detections(at, [(15.0, 0.0)] if k % 8 == 0 else [], rng, **CONE), pose(at), everywhere(True)
        )
        ids |= {item.id for item in told}
    assert ids == {1}
