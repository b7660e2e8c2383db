from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.tracking.scenes import STEP_S, detections, follow, nothing, pose

from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections
from stucksolver_perception.tracking import ObjectTracker

TRUCK, TRUCK_M = LABELS.index("truck"), (8.5, 2.9, 3.0)


def driving(t):
    return (5.0 + 8.0 * t, 3.0), (8.0, 0.0)


def parked(_):
    return (15.0, 0.0), (0.0, 0.0)


def joined(*parts):
    columns = ("label", "score", "center", "size", "yaw", "velocity")
    return Detections(parts[0].time_s, *(np.concatenate([getattr(p, c) for p in parts]) for c in columns))


def test_tracker_moving_car_keeps_id_and_has_velocity():
    """A moving car keeps its id, and its velocity is found."""
    rng = np.random.default_rng(0)
    tracker = ObjectTracker()
    ids = set()
    for k in range(40):
        place, velocity = driving(k * STEP_S)
        ids |= {track.id for track in tracker.update(detections(k * STEP_S, [place], rng, velocity), pose(k * STEP_S))}
    (track,) = tracker.predict(3.9)
    assert len(ids) == 1
    assert (track.vx_mps, track.vy_mps) == pytest.approx((8.0, 0.0), abs=0.5)
    assert track.stationary_s == 0.0
    assert track.moved_s_ago == 0.0
    assert track.hits == 40


@pytest.mark.integration
@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 0.5))
def test_predict_goes_on_with_the_velocity_and_changes_nothing(ahead):
    rng = np.random.default_rng(1)
    tracker = ObjectTracker()
    (now,) = follow(tracker, driving, 2.0, rng)
    (then,) = tracker.predict(now.time_s + ahead)
    assert then.x_m == pytest.approx(now.x_m + now.vx_mps * ahead)
    assert then.covariance[0, 0] >= now.covariance[0, 0] - 1e-12
    (again,) = tracker.predict(now.time_s)
    assert again.x_m == pytest.approx(now.x_m)


def test_tracker_second_hit_confirms_unless_near_and_certain():
    """A second hit confirms a track, and a near and certain one needs no second."""
    rng = np.random.default_rng(2)
    weak = ObjectTracker()
    assert not weak.update(detections(0.0, [(10, 0)], rng, score=0.5), pose(0.0))
    assert len(weak.update(detections(0.1, [(10, 0)], rng, score=0.5), pose(0.1))) == 1
    assert len(ObjectTracker().update(detections(0.0, [(10, 0)], rng, score=0.9), pose(0.0))) == 1
    assert not ObjectTracker().update(detections(0.0, [(40, 0)], rng, score=0.9), pose(0.0))


def test_tracker_missed_object_in_view_ends_within_1_s():
    """An object that should be visible and is missed is gone within a second."""
    tracker = ObjectTracker()
    follow(tracker, parked, 3.0, np.random.default_rng(3))
    told = [tracker.update(nothing(3.0 + k * STEP_S), pose(3.0 + k * STEP_S)) for k in range(10)]
    assert len(told[0]) == 1
    assert not told[-1]


def test_tracker_occluded_object_is_kept_with_growing_uncertainty():
    """An object occluded by a truck is kept, and its position grows uncertain."""
    rng = np.random.default_rng(4)
    tracker = ObjectTracker()
    (before,) = follow(tracker, parked, 3.0, rng)
    for k in range(60):
        t = 3.0 + k * STEP_S
        told = tracker.update(detections(t, [(8.0, 0.0)], rng, size=(2.5, 7.0, 3.5), label=1, yaw=0.0), pose(t))
    (after,) = [track for track in told if track.id == before.id]
    assert after.hidden
    assert after.covariance[0, 0] > 2 * before.covariance[0, 0]
    assert after.stationary_s > 8.0
    assert after.last_seen_s == pytest.approx(2.9)


@pytest.mark.integration
def test_tracker_moving_car_is_kept_shorter_than_stationary():
    """An occluded moving car is kept for a shorter time than a stationary one."""
    lasted = []
    for path in (parked, lambda t: ((15.0, 2.0 * t - 6.0), (0.0, 2.0))):
        rng, tracker = np.random.default_rng(5), ObjectTracker()
        (before,) = follow(tracker, path, 3.0, rng, yaw=math.pi / 2)
        for k in range(150):
            t = 3.0 + k * STEP_S
            told = tracker.update(detections(t, [(8.0, 0.0)], rng, size=(2.5, 40.0, 3.5), label=1), pose(t))
            if before.id not in {track.id for track in told}:
                break
        lasted.append(k * STEP_S)
    assert lasted[0] > 14.0
    # Once nobody knows where it is, it is no longer an object.
    assert 1.0 < lasted[1] < 3.5


def test_tracker_heading_ignores_flips_and_follows_motion():
    """A heading that flips now and then stays, and motion corrects a wrong one."""
    rng = np.random.default_rng(6)
    tracker = ObjectTracker()
    for k in range(40):
        place, velocity = driving(k * STEP_S)
        yaw = math.pi if k < 2 or k % 3 == 0 else 0.0
        told = tracker.update(detections(k * STEP_S, [place], rng, velocity, yaw=yaw), pose(k * STEP_S))
    assert abs(told[0].yaw_rad) < 0.2


def test_tracker_label_is_voted_despite_one_wrong_look():
    """The label is voted, and one wrong look does not split an object."""
    rng = np.random.default_rng(7)
    tracker = ObjectTracker()
    for k in range(20):
        label = 3 if k == 10 else 2
        told = tracker.update(
            detections(k * STEP_S, [(12.0, 1.0)], rng, label=label, size=(1.8, 0.7, 1.7)), pose(k * STEP_S)
        )
        assert len(told) <= 1
    assert told[0].label == 2
    assert 0.8 < told[0].label_confidence < 1.0


def test_cars_that_meet_do_not_swap_their_ids():
    rng = np.random.default_rng(8)
    tracker = ObjectTracker()
    seen = {}
    for k in range(50):
        t = k * STEP_S
        one = detections(t, [(8.0 * t, 1.8)], rng, (8.0, 0.0))
        other = detections(t, [(40.0 - 8.0 * t, -1.8)], rng, (-8.0, 0.0), yaw=math.pi)
        for track in tracker.update(joined(one, other), pose(t)):
            seen.setdefault(track.id, set()).add(track.y_m > 0.0)
    assert sorted(map(len, seen.values())) == [1, 1]


@pytest.mark.integration
@settings(max_examples=20, deadline=None)
@given(st.floats(-3.1, 3.1), st.floats(-100, 100), st.floats(-100, 100))
def test_tracks_are_the_same_wherever_the_local_frame_begins(yaw, x, y):
    cos, sin = math.cos(yaw), math.sin(yaw)
    trackers = ObjectTracker(), ObjectTracker()
    for k in range(6):
        t = k * STEP_S
        looks = [detections(t, [driving(t)[0]], np.random.default_rng(k), (8.0, 0.0)) for _ in range(2)]
        (here,) = trackers[0].update(looks[0], pose(t)) or (None,)
        (there,) = trackers[1].update(looks[1], pose(t, x, y, yaw)) or (None,)
    assert there.x_m == pytest.approx(x + cos * here.x_m - sin * here.y_m, abs=1e-3)
    assert there.y_m == pytest.approx(y + sin * here.x_m + cos * here.y_m, abs=1e-3)
    assert math.hypot(there.vx_mps, there.vy_mps) == pytest.approx(math.hypot(here.vx_mps, here.vy_mps), abs=1e-2)


def test_tracker_measured_height_replaces_estimates():
    """When a height is measured, estimates of it no longer count."""
    rng = np.random.default_rng(6)
    tracker = ObjectTracker()
    for k in range(40):
        known = 20 <= k < 25
        bag = {"label": LABELS.index("debris"), "size": (0.5, 0.4, 0.13 if known else 0.26), "noise": 0.2}
        found = replace(detections(k * STEP_S, [(7.0, 0.0)], rng, **bag), height_known=np.array([known]))
        (track,) = tracker.update(found, pose(k * STEP_S)) or (None,)
        if track is not None:
            assert track.height_m == pytest.approx(0.26 if k < 20 else 0.13)
    assert track.hits == 40


def test_tracker_fast_truck_with_turned_boxes_is_one_track():
    """A fast truck whose boxes are turned and have no velocity is one track with its speed.

    The detector's output for a fire truck at 60 km/h: no velocity, and yaw angles up to 90 degrees off.
    """
    rng = np.random.default_rng(12)
    tracker = ObjectTracker()
    askew = np.radians([-96.0, 40.0, -30.0, -21.0, -29.0, -44.0, -45.0, -37.0])
    ids, told = set(), ()
    for k, off in enumerate(askew):
        time_s = k * STEP_S
        seen = detections(
            time_s, [(14.0, 37.0 - 16.7 * time_s)], rng, yaw=off - math.pi / 2.0, label=TRUCK, size=TRUCK_M
        )
        told = tracker.update(seen, pose(time_s))
        ids |= {track.id for track in told}
    (track,) = told
    assert ids == {track.id}
    assert (track.vx_mps, track.vy_mps) == pytest.approx((0.0, -16.7), abs=3.0)
    assert math.remainder(track.yaw_rad + math.pi / 2.0, math.tau) == pytest.approx(0.0, abs=0.25)
