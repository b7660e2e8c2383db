from __future__ import annotations

import numpy as np
import pytest
from tests.tracking.scenes import STEP_S, detections, follow, pose

from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.tracking import ObjectTracker


def parked(_):
    return (10.0, 3.0), (0.0, 0.0)


@pytest.mark.integration
def test_parked_cars_never_seem_to_move_however_noisy_the_looks():
    rng = np.random.default_rng(1)
    places = np.array([[x, y] for x in (-20, -10, 10, 20) for y in (-6, 6)], float)
    tracker = ObjectTracker()
    for k in range(150):
        tracks = tracker.update(detections(k * STEP_S, places, rng), pose(k * STEP_S))
        if k > 40:
            assert len(tracks) == len(places)
            assert all((track.vx_mps, track.vy_mps) == (0.0, 0.0) for track in tracks)
    assert all(track.stationary_s > 13.5 and track.moved_at_s is None for track in tracks)


def test_a_parked_car_stands_still_although_the_ego_drives_by():
    rng = np.random.default_rng(2)
    tracker = ObjectTracker()
    for k in range(80):
        t, x, yaw = k * STEP_S, 8.0 * k * STEP_S - 20.0, 0.02 * np.sin(k / 5)
        away = np.array([20.0 - x, 3.0])
        turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
        (track, *others) = tracker.update(detections(t, [turn @ away], rng, yaw=-yaw), pose(t, x, 0.0, yaw, 8.0)) or [
            None
        ]
        assert not others
    assert track.stationary_s > 6.5
    assert (track.x_m, track.y_m) == pytest.approx((20.0, 3.0), abs=0.15)


@pytest.mark.parametrize("seed", range(6))
def test_tracker_car_pulling_away_is_moving_within_1_5_s(seed):
    """A car that pulls away gently is detected as moving within 1.5 s."""
    rng = np.random.default_rng(seed)
    tracker = ObjectTracker()
    follow(tracker, parked, 8.0, rng)
    for k in range(16):
        u = k * STEP_S
        (track,) = tracker.update(detections(8.0 + u, [(10.0 + 0.25 * u * u, 3.0)], rng, (0.5 * u, 0.0)), pose(8.0 + u))
        if track.standing_since_s is None:
            break
    assert track.stationary_s == 0.0
    assert track.moved_s_ago == 0.0
    assert 0.2 < track.vx_mps < 1.5


def test_tracker_stopping_car_has_stationary_time_and_last_motion():
    """A car that stops is stationary since then, and its last motion is reported."""

    def braking(t):
        u = min(t, 4.0)
        return (8.0 * u - u * u, 2.0), (8.0 - 2.0 * u, 0.0)

    (track,) = follow(ObjectTracker(), braking, 9.0, np.random.default_rng(3))
    assert track.standing_since_s == pytest.approx(4.0, abs=0.8)
    assert track.stationary_s == pytest.approx(track.time_s - 4.0, abs=0.8)
    assert track.moved_at_s <= track.standing_since_s


def test_tracker_noise_twice_as_large_moves_no_parked_car():
    """Looks twice as noisy as assumed are detected and make no parked car move."""
    (track,) = follow(ObjectTracker(), parked, 12.0, np.random.default_rng(4), noise=2.0)
    assert track.stationary_s > 7.0


def test_tracker_occluded_car_found_elsewhere_has_moved():
    """A stationary car that was occluded and is found elsewhere has moved."""
    rng = np.random.default_rng(5)
    tracker = ObjectTracker()
    follow(tracker, parked, 5.0, rng)
    told = ()
    for k in range(3):
        told = tracker.update(detections(6.0 + k * STEP_S, [(13.0, 3.0)], rng), pose(6.0 + k * STEP_S))
    if len(told) == 1:
        assert told[0].moved_at_s is not None
    assert max(told, key=lambda item: item.last_seen_s).stationary_s < 1.0


CONE = {"label": LABELS.index("cone"), "size": (0.35, 0.35, 0.6)}


def test_a_cone_stands_from_the_start_whatever_velocity_is_measured():
    rng = np.random.default_rng(3)
    tracker = ObjectTracker()
    for k in range(30):
        speed = (3.0, 1.0) if k % 4 == 0 else (0.0, 0.0)
        for track in tracker.update(detections(k * STEP_S, [(14.0, 1.6)], rng, speed, **CONE), pose(k * STEP_S)):
            assert (track.vx_mps, track.vy_mps) == (0.0, 0.0)
    assert track.stationary_s > 2.5 and track.moved_at_s is None


def test_tracker_occluded_cone_confused_with_neighbor_stays():
    """A cone that is confused with its neighbor and then occluded stays where it is."""
    rng = np.random.default_rng(4)
    tracker = ObjectTracker()
    for k in range(60):
        place = (14.9, 1.9) if k in (50, 51, 52) else (14.0, 1.6)
        tracker.update(
            detections(k * STEP_S, [place], rng, (2.0, 0.5) if k > 49 else (0.0, 0.0), **CONE), pose(k * STEP_S)
        )
    (track,) = tracker.predict(6.0 + 2.0)
    assert (track.x_m, track.y_m) == pytest.approx((14.0, 1.6), abs=0.4)
    assert float(np.sqrt(np.linalg.eigvalsh(track.covariance[:2, :2])[-1])) < 0.4


def test_a_thing_that_rolls_away_is_noticed():
    rng = np.random.default_rng(5)
    tracker = ObjectTracker()
    ball = {"label": LABELS.index("debris"), "size": (0.3, 0.3, 0.3)}
    follow(tracker, lambda _: ((10.0, 3.0), (0.0, 0.0)), 3.0, rng, **ball)
    told = follow(tracker, lambda t: ((10.0, 3.0 - (t - 3.0)), (0.0, -1.0)), 3.0, rng, start_s=3.0, **ball)
    assert any(track.vy_mps == pytest.approx(-1.0, abs=0.4) and track.y_m < 0.5 for track in told)


def shifting(way):
    """A car whose place along x is at `way` (m) at 6, 6.6, 7.2, 7.8 s, in between linearly."""
    times = [6.0, 6.6, 7.2, 7.8]

    def path(t):
        later, now = (float(np.interp(at, times, way)) for at in (t + STEP_S, t))
        return (10.0 + now, 3.0), ((later - now) / STEP_S, 0.0)

    return path


@pytest.mark.parametrize("seed", range(3))
def test_tracker_car_with_wandering_box_stays_stationary(seed):
    """A car whose box wandered and came back was stationary all the time.

    This happens while the ego backs up: otherwise the ego waits for it like for a car in a queue.
    """
    rng, tracker, path = np.random.default_rng(seed), ObjectTracker(), shifting([0.0, 0.9, 0.9, 0.1])
    moved, told = False, ()
    for k in range(140):
        place, velocity = path(k * STEP_S)
        told = tracker.update(detections(k * STEP_S, [place], rng, velocity), pose(k * STEP_S))
        moved = moved or (k > 20 and told[0].standing_since_s is None)
    assert moved, "the test needs a car that seems to move"
    assert told[0].moved_at_s is None
    assert told[0].stationary_s > 13.0


@pytest.mark.parametrize("seed", range(3))
def test_a_car_that_has_moved_up_has_moved(seed):
    (track,) = follow(ObjectTracker(), shifting([0.0, 0.6, 1.2, 1.2]), 14.0, np.random.default_rng(seed))
    assert track.moved_at_s == pytest.approx(7.0, abs=1.0)
    assert track.stationary_s < 8.0
