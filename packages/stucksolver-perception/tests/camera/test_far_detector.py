"""From the network's outputs to boxes, and what a recording says should be found."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from lab.perception.training.camera.far_data import BOX_FIELDS, boxes_of
from stucksolver.scene import ObjectKind
from stucksolver_perception.camera.far_detector import MAX_DETECTIONS, VERSION, FarDetector, decode
from stucksolver_perception.camera.horizon_strip import STRIDE
from stucksolver_perception.measurements import LidarSweep, Singles
from stucksolver_perception.network_files import NetworkFileError
from stucksolver_perception.recording import KINDS, Recorded, Truth
from stucksolver_perception.rig import load_rig

CAMERA = load_rig().camera
ROWS, COLUMNS, TOP = 48, 400, 354


def outputs() -> tuple[np.ndarray, np.ndarray]:
    return np.zeros((3, ROWS, COLUMNS), np.float32), np.zeros((6, ROWS, COLUMNS), np.float32)


def test_a_peak_becomes_a_box_in_the_pictures_pixels() -> None:
    peaks, rest = outputs()
    peaks[0, 26, 190] = 0.8
    rest[:, 26, 190] = np.log(12.0 / STRIDE), np.log(10.0 / STRIDE), 0.25, -0.5, 1.0, 3.0
    found = decode(peaks, rest, 7.0, TOP, 0.3, np.zeros(2))
    assert found.time_s == 7.0
    assert len(found) == 1 and found.label[0] == 0
    assert (found.width[0], found.height[0]) == pytest.approx((12.0, 10.0), rel=1e-5)
    assert found.column[0] == pytest.approx((190 + 0.5 + 0.25) * STRIDE)
    assert found.row[0] == pytest.approx(TOP + (26 + 0.5 + 1.0) * STRIDE)
    assert found.towards[0] > 0.9


def test_weak_peaks_are_left_out_and_the_surest_come_first() -> None:
    peaks, rest = outputs()
    peaks[1, 5, 5], peaks[2, 9, 9], peaks[0, 1, 1] = 0.5, 0.9, 0.1
    found = decode(peaks, rest, 0.0, TOP, 0.3, np.zeros(2))
    assert found.label.tolist() == [2, 1]


def test_decode_drops_duplicate_peak_and_keeps_neighbor() -> None:
    """A second peak of the same object is dropped, and a neighbor is kept."""
    peaks, rest = outputs()
    for label, x, score in ((0, 100, 0.9), (0, 102, 0.5), (1, 100, 0.4), (0, 120, 0.6)):
        peaks[label, 20, x] = score
    rest[:2] = np.log(40.0 / STRIDE)
    found = decode(peaks, rest, 0.0, TOP, 0.3, np.zeros(2))
    assert found.score == pytest.approx([0.9, 0.6])


def test_a_wild_network_gives_finite_boxes_and_not_too_many() -> None:
    random = np.random.default_rng(4)
    peaks, rest = (1e3 * random.normal(size=output.shape).astype(np.float32) for output in outputs())
    with np.errstate(over="ignore"):
        found = decode(peaks, rest, 0.0, TOP, 0.3, np.zeros(2))
    assert 0 < len(found) <= MAX_DETECTIONS
    assert np.isfinite(found.width).all() and np.isfinite(found.height).all()


def test_without_weights_the_detector_names_the_missing_file(tmp_path: Path) -> None:
    with pytest.raises(NetworkFileError, match=r"far\.json"):
        FarDetector(tmp_path)


def test_damaged_weights_are_refused(tmp_path: Path) -> None:
    (tmp_path / "far.onnx").write_bytes(b"not what was trained")
    card = {"version": VERSION, "sha256": hashlib.sha256(b"what was trained").hexdigest(), "threshold": 0.3}
    (tmp_path / "far.json").write_text(json.dumps(card), encoding="utf-8")
    with pytest.raises(NetworkFileError, match="damaged"):
        FarDetector(tmp_path)


def tick(kind: ObjectKind, x: float, y: float, yaw: float, shown: float, pitch: float = 0.0) -> Recorded:
    """One actor, of whose rectangle in the mask a share from the top is shown."""
    box = np.array([[x, y, 0.75, yaw, 4.5, 1.9, 1.5, 0.0, 0.0]])
    kinds, zero = np.array([KINDS.index(kind)]), np.zeros(1, int)
    truth = Truth(np.array([70000]), kinds, box, zero, zero, zero - 1, zero - 1, ("",))
    mask = np.zeros((CAMERA.height_px, CAMERA.width_px), np.uint16)
    if shown:
        # At no pitch: where a car's front is seen at x, y.
        column, row, _ = CAMERA.project(np.array([[x - 2.25, y + 0.95, 1.5], [x - 2.25, y - 0.95, 0.0]]))
        last = row[0] + shown * (row[1] - row[0])
        mask[round(row[0]) : round(last), round(column[0]) : round(column[1])] = 70000 % 65536
    nothing = np.zeros(7)
    return Recorded(
        time_s=0.0,
        pose=np.array([0.0, 0.0, 0.0, 0.0, pitch, 0.0, 0.0, 0.0, 0.0]),
        sweep=LidarSweep(0.0, np.zeros((0, 4), np.float32)),
        imu=nothing,
        gnss=nothing[:3],
        wheel_mps=0.0,
        truth=truth,
        lights=None,
        jpeg=None,
        instances=mask,
    )


def field(boxes: Singles, name: str) -> float:
    return float(boxes[0, BOX_FIELDS.index(name)])


def test_boxes_of_fully_visible_car_fill_its_outline() -> None:
    """A car in full view is taught with the box that it fills."""
    boxes = boxes_of(tick(ObjectKind.CAR, 120.0, 3.5, np.pi, 1.0), CAMERA)
    column, row, _ = CAMERA.project(np.array([[117.75, 4.45, 0.0]]))
    assert field(boxes, "label") == 0
    assert field(boxes, "left") == pytest.approx(column[0], abs=0.5)
    assert field(boxes, "bottom") == pytest.approx(row[0], abs=0.1)
    assert field(boxes, "share") > 0.9
    assert field(boxes, "distance") == pytest.approx(np.hypot(120.0, 3.5))


@pytest.mark.parametrize(("yaw", "towards"), [(np.pi, 1), (0.0, 0), (np.pi / 2, -1)])
def test_front_and_rear_are_told_apart_by_the_heading(yaw: float, towards: int) -> None:
    assert field(boxes_of(tick(ObjectKind.CAR, 120.0, 3.5, yaw, 1.0), CAMERA), "towards") == towards


def test_of_a_car_that_is_nearly_hidden_nothing_is_taught() -> None:
    assert field(boxes_of(tick(ObjectKind.CAR, 100.0, 0.0, 0.0, 0.15), CAMERA), "label") == -1


def test_a_hidden_car_is_road() -> None:
    assert len(boxes_of(tick(ObjectKind.CAR, 100.0, 0.0, 0.0, 0.0), CAMERA)) == 0


def test_a_person_is_a_person_and_a_cone_is_nothing() -> None:
    assert field(boxes_of(tick(ObjectKind.PEDESTRIAN, 50.0, 0.0, 0.0, 1.0), CAMERA), "label") == 2
    assert len(boxes_of(tick(ObjectKind.CONE, 50.0, 0.0, 0.0, 1.0), CAMERA)) == 0


def test_a_nose_that_is_down_lifts_boxes_in_the_picture() -> None:
    level, down = (boxes_of(tick(ObjectKind.CAR, 100.0, 0.0, 0.0, 1.0, pitch), CAMERA) for pitch in (0.0, 0.01))
    lifted = field(level, "bottom") - field(down, "bottom")
    assert lifted == pytest.approx(0.01 * CAMERA.focal_px, rel=0.05)


def test_boxes_of_actor_beyond_range_are_ignored() -> None:
    """An actor beyond the recorded range is left out of the loss."""
    one = tick(ObjectKind.CAR, 100.0, 0.0, 0.0, 1.0)
    assert one.instances is not None
    one.instances[440:450, 900:912] = 4711
    boxes = boxes_of(one, CAMERA)
    assert boxes[:, 0].tolist() == [0, -1]
    assert boxes[1, 1:5].tolist() == [900, 440, 912, 450]
