"""A stationary vehicle that the detector misses, but from which returns still come."""

from __future__ import annotations

import numpy as np
import pytest
from tests.tracking.scenes import STEP_S, detections, follow, nothing, pose

from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.tracking import ObjectTracker

VAN = {"label": LABELS.index("truck"), "size": (5.0, 2.0, 2.3)}


def rear(x: float = 7.4, y: float = 0.0) -> np.ndarray:
    """Returns from a van's rear."""
    across, up = np.meshgrid(np.linspace(-0.9, 0.9, 10), np.linspace(0.5, 1.9, 4))
    return np.column_stack([np.full(across.size, x), across.ravel() + y, up.ravel()])


def behind_a_van(speed: float = 0.0) -> ObjectTracker:
    tracker = ObjectTracker()
    follow(tracker, lambda t: ((9.9 + speed * t, 0.0), (speed, 0.0)), 3.0, np.random.default_rng(0), **VAN)
    return tracker


def told_after(tracker: ObjectTracker, seconds: float, standing: np.ndarray, label: str | None = None) -> tuple:
    """The tracks after looks in which the van is not detected, but something of this label at its rear is."""
    told, rng = (), np.random.default_rng(1)
    for k in range(round(seconds / STEP_S)):
        t = 3.0 + k * STEP_S
        found = nothing(t)
        if label is not None:
            found = detections(t, [(7.6, 0.0)], rng, label=LABELS.index(label), size=(0.4, 0.6, 1.6), noise=0.1)
        told = tracker.update(found, pose(t), None, standing)
    return told


def test_tracker_missed_vehicle_with_returns_keeps_id():
    """The track goes on with the same id while returns come from the vehicle's rear."""
    assert [track.id for track in told_after(behind_a_van(), 10.0, rear())] == [1]


def test_without_returns_it_ends():
    assert told_after(behind_a_van(), 10.0, np.zeros((0, 3))) == ()
    assert told_after(behind_a_van(), 10.0, rear(y=2.5)) == ()
    assert told_after(behind_a_van(), 10.0, rear()[:5]) == ()


@pytest.mark.parametrize(("label", "height"), [("debris", 0.4), ("barrier", 1.0), ("cone", 0.7), ("pedestrian", 1.7)])
@pytest.mark.parametrize(("y", "kept"), [(0.1, True), (2.5, False)])
def test_tracker_object_in_path_is_kept_by_few_returns(label, height, y, kept):
    """A few returns keep an object in the path, and not one beside it."""
    tracker, size = ObjectTracker(), (0.6, 0.5, height)
    thing = {"label": LABELS.index(label), "size": size}
    follow(tracker, lambda _: ((7.8, y), (0.0, 0.0)), 4.0, np.random.default_rng(2), noise=0.3, **thing)
    rays = np.column_stack([np.full(6, 7.6), np.linspace(y - 0.2, y + 0.2, 6), np.full(6, 0.8 * height)])
    rng, told = np.random.default_rng(3), ()
    for k in range(60):
        t = 4.0 + k * STEP_S
        weak = detections(t, [(7.8, y)] if k % 2 else [], rng, score=0.15, noise=0.3, **thing)
        told = tracker.update(weak, pose(t), None, rays)
    assert [track.id for track in told] == ([1] if kept else [])


def test_one_that_was_driving_is_not_held_back_by_returns():
    assert told_after(behind_a_van(speed=6.0), 10.0, rear(x=27.0)) == ()


def test_tracker_object_at_rear_merges_and_pedestrian_does_not():
    """An object at the vehicle's rear is a part of it, and a pedestrian is a pedestrian."""
    assert [LABELS[track.label] for track in told_after(behind_a_van(), 2.0, rear(), "barrier")] == ["truck"]
    assert {LABELS[t.label] for t in told_after(behind_a_van(), 2.0, rear(), "pedestrian")} == {"truck", "pedestrian"}


def test_tracker_bus_driven_on_leaves_old_place_free():
    """The rear of a bus that has driven on does not keep the place that it left.

    Its new box is 5 m ahead; its rear is within the old one, 11 m long.
    """
    tracker, rng = ObjectTracker(), np.random.default_rng(4)
    bus = {"label": LABELS.index("truck"), "size": (11.0, 2.5, 3.1)}
    follow(tracker, lambda _: ((12.9, 0.0), (0.0, 0.0)), 3.0, rng, **bus)
    told, rays = (), rear(x=11.8)  # its new box begins 0.6 m further on
    for k in range(40):
        t = 3.0 + k * STEP_S
        told = tracker.update(detections(t, [(17.9, 0.0)], rng, noise=0.3, **bus), pose(t), None, rays)
    assert len(told) == 1
    assert told[0].x_m > 17.0
