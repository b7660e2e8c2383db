"""What is doubtful stays so: second labels for one thing, and what is found weakly and now and then."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.tracking.scenes import STEP_S, detections, follow, nothing, pose
from tests.tracking.test_hidden import everywhere
from tests.tracking.test_object_tracker import joined

from stucksolver_perception.tracking import ObjectTracker
from stucksolver_perception.tracking.association import suppress_duplicates

BICYCLE, BARRIER, PEDESTRIAN, CONE = 2, 6, 3, 5


def two(time_s, rng, first=0.9, second=0.5):
    """A parked bicycle, and the same again as a barrier."""
    bicycle = detections(time_s, [(12.0, 3.0)], rng, label=BICYCLE, size=(1.8, 0.6, 1.3), score=first)
    return joined(bicycle, detections(time_s, [(12.1, 3.0)], rng, label=BARRIER, size=(1.5, 0.5, 1.0), score=second))


@pytest.mark.integration
def test_one_thing_under_two_labels_is_one_object():
    rng, tracker = np.random.default_rng(0), ObjectTracker()
    for k in range(20):
        told = tracker.update(two(k * STEP_S, rng), pose(k * STEP_S))
        assert [track.label for track in told] == [BICYCLE]


def test_suppress_duplicates_keeps_better_label_and_neighbor():
    """The better of two detections at one place remains, and a neighbor is kept."""
    rng = np.random.default_rng(1)
    walker = detections(0.0, [(12.0, 4.5)], rng, label=PEDESTRIAN, size=(0.5, 0.5, 1.8), score=0.3)
    both = joined(two(0.0, rng, first=0.4, second=0.8), walker)
    assert both.label[suppress_duplicates(both)].tolist() == [BARRIER, PEDESTRIAN]


def test_tracker_weak_intermittent_detections_stay_uncertain():
    """An object that is found weakly and now and then never becomes certain."""
    rng, tracker, told = np.random.default_rng(2), ObjectTracker(), []
    for k in range(60):
        look = nothing(k * STEP_S) if k % 3 else detections(k * STEP_S, [(15.0, 4.0)], rng, label=4, score=0.6)
        told += tracker.update(look, pose(k * STEP_S), everywhere(False, nearest_m=14.0))
    assert told
    assert max(track.confidence for track in told) < 0.9
    assert np.median([track.confidence for track in told]) < 0.65


def test_what_is_found_surely_in_every_look_does():
    (track,) = follow(ObjectTracker(), lambda _: ((15.0, 4.0), (0.0, 0.0)), 2.0, np.random.default_rng(3), score=0.9)
    assert track.confidence > 0.95


def test_tracker_lagging_detected_velocity_makes_no_track_lag():
    """A velocity that lags in every look makes no track lag."""
    rng, tracker = np.random.default_rng(4), ObjectTracker()
    for k in range(15):
        t = k * STEP_S
        (track,) = tracker.update(detections(t, [(5.0 + 15.0 * t, 3.0)], rng, (7.0, 0.0)), pose(t)) or (None,)
    assert math.isclose(track.vx_mps, 15.0, abs_tol=1.0)


def missed(label, size, looks):
    """Found in ten looks, then missed in some while rays pass over its place: how many tracks are told of."""
    rng, tracker = np.random.default_rng(5), ObjectTracker()
    for k in range(10):
        tracker.update(detections(k * STEP_S, [(12.0, 1.0)], rng, label=label, size=size, score=0.7), pose(k * STEP_S))
    for k in range(10, 10 + looks):
        told = tracker.update(nothing(k * STEP_S), pose(k * STEP_S), everywhere(True))
    return len(told)


def test_tracker_rays_above_bag_do_not_end_track():
    """Rays that pass over a bag do not show that it is gone."""
    bag, walker = (7, (0.5, 0.5, 0.3)), (PEDESTRIAN, (0.5, 0.5, 1.8))
    assert (missed(*bag, looks=8), missed(*walker, looks=8)) == (1, 0)
    assert missed(*bag, looks=25) == 0, "it is not found for too long"


def test_tracker_stopped_pedestrian_does_not_become_bicycle():
    """A pedestrian who walked and then stopped does not become a bicycle.

    Two pedestrians close together look like one.
    """
    rng, tracker = np.random.default_rng(3), ObjectTracker()
    walks = follow(tracker, lambda t: ((5.0, -4.0 + 1.3 * t), (0.0, 1.3)), 2.5, rng, label=PEDESTRIAN)
    assert walks and walks[0].moved_at_s is not None
    here = (5.0, -0.75)
    follow(tracker, lambda t: (here, (0.0, 0.0)), 3.0, rng, start_s=2.5, label=PEDESTRIAN)
    told = follow(tracker, lambda t: (here, (0.0, 0.0)), 8.0, rng, start_s=5.5, label=BICYCLE, size=(1.5, 0.7, 1.7))
    assert [track.label for track in told] == [PEDESTRIAN]


def test_tracker_parked_bicycle_labeled_pedestrian_becomes_bicycle():
    """A parked bicycle that was first labeled a pedestrian becomes a bicycle."""
    rng, tracker = np.random.default_rng(4), ObjectTracker()
    follow(tracker, lambda t: ((5.0, -0.75), (0.0, 0.0)), 3.0, rng, label=PEDESTRIAN)
    told = follow(tracker, lambda t: ((5.0, -0.75), (0.0, 0.0)), 8.0, rng, start_s=3.0, label=BICYCLE)
    assert [track.label for track in told] == [BICYCLE]


@pytest.mark.parametrize(
    ("label", "aside_m", "after_s", "born"),
    [
        (CONE, 1.4, -0.45, False),
        (CONE, 1.4, 0.3, False),
        (CONE, 1.4, 0.9, True),
        (CONE, 2.2, 0.3, True),
        (PEDESTRIAN, 1.4, 0.3, True),
    ],
)
def test_tracker_static_object_beside_passing_car_is_not_created(label, aside_m, after_s, born):
    """No static object is created beside a car that passes, nor in its tail.

    The car's rear passes a place 15 m ahead; `after_s` later, an object is found there, beside the car's path.
    """
    rng, tracker, speed = np.random.default_rng(4), ObjectTracker(), 7.0

    def path(t):
        return (15.0 + 2.25 + speed * (t - 2.0), 4.0), (speed, 0.0)

    follow(tracker, path, 2.0 + after_s, rng)
    now = 2.0 + after_s
    place, velocity = path(now)
    car = detections(now, [place], rng, velocity)
    thing = detections(now, [(15.0, 4.0 - aside_m)], rng, label=label, size=(0.5, 0.5, 0.7), score=0.9, noise=0.1)
    told = tracker.update(joined(car, thing), pose(now))
    assert (label in [track.label for track in told]) is born
