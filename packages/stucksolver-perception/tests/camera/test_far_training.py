"""Training of the far detector: targets, augmentation, the figures of the check, and the export."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="training needs torch")

from lab.perception.training.camera.far_data import MARGIN_ROWS, MOST_BOXES, Strips  # noqa: E402
from lab.perception.training.camera.far_evaluate import _match, check  # noqa: E402
from lab.perception.training.camera.far_net import CHANNELS, CLASSES, FarNet, loss_of  # noqa: E402
from lab.perception.training.camera.far_train import _Batches, outputs_of  # noqa: E402
from stucksolver_perception.camera.camera_sight_distance import SightModel  # noqa: E402
from stucksolver_perception.camera.far_detector import FarDetector, decode  # noqa: E402
from stucksolver_perception.camera.horizon_strip import STRIDE, STRIP_ROWS  # noqa: E402
from stucksolver_perception.measurements import CameraFrame  # noqa: E402
from stucksolver_perception.rig import load_rig  # noqa: E402

CAMERA = load_rig().camera
ROWS, COLUMNS, TOP = 12, 40, 400


def box(label: float, left: float, top: float, right: float, bottom: float, distance: float = 100.0) -> list[float]:
    return [label, left, top, right, bottom, 1.0, distance, 1.0, 7.0, 1.9]


def padded(*rows: list[float]) -> np.ndarray:
    boxes = np.full((MOST_BOXES, 10), np.nan, np.float32)
    boxes[: len(rows)] = np.array(rows, np.float32).reshape(-1, 10)
    return boxes


def perfect(left: float, top: float, right: float, bottom: float) -> torch.Tensor:
    """The output of a network that knows one vehicle."""
    raw = torch.full((1, CHANNELS, ROWS, COLUMNS), -9.0)
    raw[:, CLASSES:] = 0.0
    x, y = (left + right) / 2 / STRIDE, ((top + bottom) / 2 - TOP) / STRIDE
    for cy in range(ROWS):
        for cx in range(COLUMNS):
            size = np.log((right - left) / STRIDE), np.log((bottom - top) / STRIDE)
            edge = (bottom - TOP) / STRIDE - cy - 0.5
            raw[0, CLASSES:, cy, cx] = torch.tensor([*size, x - cx - 0.5, y - cy - 0.5, edge, 9.0])
    raw[0, 0, int(y), int(x)] = 9.0
    return raw


def loss(raw: torch.Tensor, boxes: np.ndarray) -> float:
    return float(loss_of(raw, torch.from_numpy(boxes[None]), torch.tensor([[0.0, float(TOP)]])))


def test_loss_is_low_for_exact_box_and_higher_off() -> None:
    """A network that has the exact box has hardly any loss, and one with an error has more."""
    boxes = padded(box(0, 60, 420, 72, 430))
    assert loss(perfect(60, 420, 72, 430), boxes) < 0.05
    assert loss(perfect(60, 420, 72, 434), boxes) > 0.2
    assert loss(perfect(90, 420, 102, 430), boxes) > 5.0


def test_loss_of_ignored_box_is_zero_for_any_output() -> None:
    """A box of unknown label costs nothing, whatever the network outputs there."""
    unknown = padded(box(-1, 60, 420, 72, 430))
    assert loss(perfect(60, 420, 72, 430), unknown) < 0.05 < 1.0 < loss(perfect(60, 420, 72, 430), padded())


def test_what_the_outputs_say_is_decoded_to_the_same_box() -> None:
    raw = perfect(60, 420, 72, 430)[0]
    found = decode(torch.sigmoid(raw[:CLASSES]).numpy(), raw[CLASSES:].numpy(), 0.0, TOP, 0.5, np.zeros(2))
    assert [found.column[0], found.row[0], found.width[0], found.height[0]] == pytest.approx([66, 430, 12, 10])


def strips(n: int = 6) -> Strips:
    """Gray pictures with a white car in each, at other places, in two drives."""
    random = np.random.default_rng(5)
    rgb = np.full((n, STRIP_ROWS + 2 * MARGIN_ROWS, CAMERA.width_px, 3), 90, np.uint8)
    top, boxes = 450 - STRIP_ROWS // 2 - MARGIN_ROWS, []
    for k in range(n):
        x, y = int(random.integers(100, 1400)), int(random.integers(440, 470))
        rgb[k, y - top : y - top + 12, x : x + 16] = 250
        boxes.append(padded(box(0, x, y, x + 16, y + 12)))
    about = (("a", "day"), ("b", "night"))
    return Strips(rgb, np.full(n, top), np.array(boxes), np.arange(n) / 2.0, np.arange(n) * 2 // n, about, CAMERA)


def test_batches_boxes_stay_on_cars_after_augmentation() -> None:
    """Boxes stay on their cars when strips are cut, shifted and turned."""
    batches = _Batches(strips(), torch.device("cpu"), 24, 1)
    pixels, boxes, shift = batches.draw()
    checked = 0
    for picture, rows, (left, top) in zip(pixels, boxes, shift.tolist(), strict=True):
        a, b, c, d = (rows[0, 1:5] - torch.tensor([left, top, left, top])).round().int().tolist()
        if a >= 0 and c <= picture.shape[2] and b >= 0 and d <= picture.shape[1]:
            inside, around = picture[:, b:d, a:c].mean(), picture.mean()
            assert inside > around + 0.5
            checked += 1
    assert checked > 5


def test_match_is_unique_and_second_detection_is_false() -> None:
    """A detection is matched once, and a second one beside it is false."""
    raw = perfect(60, 420, 72, 430)[0]
    raw[0, 6, 18] = 4.0
    raw[CLASSES : CLASSES + 2, 6, 18] = 0.0
    found = decode(torch.sigmoid(raw[:CLASSES]).numpy(), raw[CLASSES:].numpy(), 0.0, TOP, 0.5, np.zeros(2))
    assert _match(found, padded(box(0, 60, 420, 72, 430)), 0).truth.tolist() == [0, -1]
    assert _match(found, padded(box(0, 300, 420, 312, 430)), 0).truth.tolist() == [-1, -1]


def test_the_shipped_file_says_what_the_network_says(tmp_path: Path) -> None:
    pytest.importorskip("onnx", reason="the export needs onnx")
    pytest.importorskip("onnxruntime")
    from lab.perception.training.camera.far_export import export

    pictures = strips()
    net = FarNet().eval()
    card = export(net, tmp_path, check(outputs_of(net, torch.device("cpu")), pictures), pictures)
    assert SightModel.from_card(card).reach_m(np.array([90.0, 0.0])) <= 25.0
    rgb = np.full((CAMERA.height_px, CAMERA.width_px, 3), 90, np.uint8)
    assert len(FarDetector(tmp_path).detect(CameraFrame(1.0, rgb), CAMERA)) == 0
