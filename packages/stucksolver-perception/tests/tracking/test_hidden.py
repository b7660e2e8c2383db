from __future__ import annotations

import math

import numpy as np
import pytest
from tests.tracking.scenes import STEP_S, detections, follow, nothing, pose

from stucksolver_perception.free_space import AZIMUTHS, CELL_M, FreeSpace
from stucksolver_perception.rig import load_rig
from stucksolver_perception.tracking import ObjectTracker

LIDAR = load_rig().lidar


def everywhere(seen, nearest_m=math.inf):
    cells = np.full((AZIMUTHS, int(LIDAR.range_m / CELL_M)), seen)
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


def test_who_was_not_found_is_soon_gone_where_its_place_was_seen_to_be_free():
    assert kept_for_s(everywhere(True)) <= 0.8


def test_what_the_detector_no_longer_sees_in_a_wall_fades_within_seconds():
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
def test_what_lies_before_the_nose_is_not_forgotten_while_the_ego_stands():
    """Rays pass above it, and nobody has seen it go."""
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


def test_a_thing_beside_a_vehicle_that_stands_stays_where_it_was():
    assert hidden_cone_after(20.0, speed=0.0) < 0.1
    # While the vehicle moves, its own place becomes less certain, but the thing does not set off.
    assert 0.1 < hidden_cone_after(20.0, speed=1.0) < 0.3


def test_a_cone_found_only_now_and_then_keeps_its_id_though_rays_pass_above_it():
    tracker, rng, ids = ObjectTracker(), np.random.default_rng(3), set()
    follow(tracker, lambda _: ((15.0, 0.0), (0.0, 0.0)), 3.0, rng, **CONE)
    for k in range(100):
        at = 3.0 + k * STEP_S
        told = tracker.update(
            detections(at, [(15.0, 0.0)] if k % 8 == 0 else [], rng, **CONE), pose(at), everywhere(True)
        )
        ids |= {item.id for item in told}
    assert ids == {1}
