"""Recordings as windows to learn from."""

import math
from pathlib import Path

import numpy as np
import pytest
from tests.lidar.synthetic import drive

from lab.perception.training.lidar.data import HISTORY, IGNORED, SweepWindows, label_of, load, returns_in, vehicle_frame
from stucksolver.scene import ObjectKind
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Floats
from stucksolver_perception.recording import RecordingError


@pytest.fixture(scope="module")
def windows(tmp_path_factory: pytest.TempPathFactory) -> SweepWindows:
    folder = tmp_path_factory.mktemp("drives")
    drive(folder / "a", seed=1, ticks=24)
    drive(folder / "b", seed=2, ticks=12)
    return load([folder], jobs=1, every=2)


def test_windows_end_at_every_second_tick_after_full_history(windows: SweepWindows) -> None:
    ends = windows.history[:, 0].tolist()
    assert ends == [*range(5, 24, 2), *range(24 + 5, 24 + 12, 2)]


def test_a_history_is_made_of_ticks_one_after_the_other(windows: SweepWindows) -> None:
    full = windows.history[(windows.history >= 0).all(axis=1)]
    assert full.shape[1] == HISTORY
    assert (np.diff(full, axis=1) == -1).all()
    assert np.diff(windows.time_s[full], axis=1) == pytest.approx(-0.05)


def test_boxes_lie_on_their_points(windows: SweepWindows) -> None:
    taught = np.concatenate(
        [boxes[labels != IGNORED] for boxes, labels in zip(windows.boxes, windows.labels, strict=True)]
    )
    # Each tick puts 60 points on each body; two ticks are a turn. Cones lose those near the ground.
    assert len(taught) > 50
    assert np.median(taught[:, 9]) > 100


def test_kinds_without_a_label_and_bodies_hardly_hit_are_ignored(tmp_path: Path) -> None:
    drive(tmp_path, seed=1, per_body=1)
    labels = np.concatenate(load([tmp_path], jobs=1).labels)
    assert len(labels) and (labels == IGNORED).all()
    assert label_of(ObjectKind.PROP, 1.0) == IGNORED
    assert label_of(ObjectKind.UNKNOWN, 1.0) == IGNORED


def test_a_long_emergency_vehicle_is_a_truck() -> None:
    assert LABELS[label_of(ObjectKind.EMERGENCY, 4.9)] == "car"
    assert LABELS[label_of(ObjectKind.EMERGENCY, 8.2)] == "truck"


def test_boxes_are_seen_from_a_vehicle_that_leans() -> None:
    """With the nose 0.1 rad down, what is straight ahead on flat ground is above the vehicle's own plane."""
    box = np.array([[12.0, 5.0, 1.0, math.pi / 2, 4.0, 2.0, 1.5, 0.0, 3.0]])
    pose: Floats = np.array([12.0, -5.0, 1.0, math.pi / 2, 0.1, 0.0, 0.0, 0.0, 0.0])
    seen = vehicle_frame(box, pose)[0]
    expected = [10.0 * math.cos(0.1), 0.0, 10.0 * math.sin(0.1), 4.0, 2.0, 1.5, 0.0, 3.0, 0.0]
    np.testing.assert_allclose(seen, expected, atol=1e-9)


def test_the_ground_below_a_box_is_no_return_of_it() -> None:
    box = np.array([[5.0, 0.0, 0.5, 2.0, 2.0, 1.0, 0.3, 0.0, 0.0]])
    points = np.array([[5.0, 0.0, 0.01], [5.0, 0.5, 0.3], [5.0, 0.5, 1.5], [8.0, 0.0, 0.5]], np.float32)
    assert returns_in(box, points).tolist() == [1.0]


def test_a_folder_without_recordings_and_one_without_windows_are_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="no recordings found"):
        load([tmp_path], jobs=1)
    drive(tmp_path / "short", seed=1, ticks=3)
    with pytest.raises(ValueError, match="long enough"):
        load([tmp_path], jobs=1)
