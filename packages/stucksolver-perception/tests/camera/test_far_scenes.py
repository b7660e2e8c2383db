"""Scenes made up for the far detector."""

from __future__ import annotations

import numpy as np
import pytest

from stucksolver_perception.camera.far_detector import FarDetector
from stucksolver_perception.measurements import CameraFrame
from stucksolver_perception.network_files import DATA
from stucksolver_perception.recording import Recording

pytest.importorskip("carla")
from lab.perception.recording.far_scene_poses import ActorPose
from lab.perception.recording.far_scenes import LOOK_S, FarDrive, record
from lab.perception.training.camera.far_data import boxes_of

LEAST_FOUND = 0.8


def test_a_vehicle_moves_along_its_heading() -> None:
    moved = ActorPose(1.0, 2.0, 3.0, 0.0, 90.0, 0.0, 10.0).moved(0.5)
    assert (moved.x, moved.y, moved.z) == pytest.approx((1.0, 7.0, 3.0))


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    folder = tmp_path_factory.mktemp("far")
    assert record(FarDrive(folder, "interurban", None, seed=5, scenes=6)) == 12
    return Recording(folder)


@pytest.mark.release
@pytest.mark.slow
@pytest.mark.integration
def test_a_drive_shows_each_scene_twice_with_vehicles_far_ahead(drive: Recording) -> None:
    ticks = list(drive)
    times = np.array([tick.time_s for tick in ticks])
    assert times[1::2] - times[::2] == pytest.approx(np.full(6, LOOK_S))
    boxes = np.concatenate([boxes_of(tick, drive.rig.camera) for tick in ticks])
    assert ((boxes[:, 0] == 0) & (boxes[:, 6] > 100.0)).sum() >= 4
    assert np.isin(boxes[boxes[:, 0] >= 0, 8] % 65536, np.concatenate([t.truth.actor_id for t in ticks]) % 65536).all()


@pytest.mark.slow
@pytest.mark.integration
def test_shipped_detector_finds_most_visible_vehicles_to_100_m(drive: Recording) -> None:
    """The shipped detector finds most vehicles in full view up to 100 m."""
    if not (DATA / "far.onnx").is_file():
        pytest.skip("the detector was not trained yet")
    detector, camera = FarDetector(), drive.rig.camera
    found = wanted = 0
    for tick in drive:
        picture = tick.picture()
        assert picture is not None
        seen = detector.detect(CameraFrame(tick.time_s, picture), camera)
        for box in boxes_of(tick, camera):
            if box[0] == 0 and box[5] > 0.7 and 30.0 < box[6] < 100.0:
                wanted += 1
                off = np.abs(seen.column - (box[1] + box[3]) / 2) + np.abs(seen.row - box[4])
                found += bool((off[seen.label == 0] < 0.5 * (box[3] - box[1]) + 3.0).any())
    assert wanted >= 3
    assert found >= LEAST_FOUND * wanted
