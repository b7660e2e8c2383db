"""Crops with labels from recordings, thresholds from held-out crops, and a training run from end to end."""

import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lab.perception.training.camera.crops_data import Crops, crops_in
from lab.perception.training.camera.crops_evaluate import Logits, cross_check, halves, least_confidence, temperature_of
from stucksolver.scene import ObjectKind
from stucksolver_perception.camera.crop_network import GESTURES, KINDS, LIGHTS, NEVER, NOTHING, CropNetwork
from stucksolver_perception.measurements import LidarSweep
from stucksolver_perception.network_files import NetworkFileError
from stucksolver_perception.recording import KINDS as RECORDED
from stucksolver_perception.recording import LightTruth, Recorded, RecordingWriter, Truth
from stucksolver_perception.rig import load_rig
from stucksolver_perception.vehicle_frame import boxes_in_body

BRAKE, LEFT = 8, 32
CAR, HIDDEN_CAR, LIGHT = 300, 301, 70_000
"""Ids; the last is larger than a mask's pixel can hold."""


def recorded() -> Recorded:
    """A car 20 m ahead of an ego that looks to the north, one that nobody sees, and a red light."""
    from PIL import Image

    mask = np.zeros((900, 1600), np.uint16)
    mask[400:550, 730:870] = CAR
    mask[100:600, 950:1300] = LIGHT % 65536
    file = io.BytesIO()
    Image.new("RGB", (1600, 900), (90, 90, 90)).save(file, "JPEG")
    north = np.pi / 2
    boxes = np.array(
        [[100.0, 70.0, 0.8, north, 4.5, 1.9, 1.6, 0, 0], [104.0, 75.0, 0.8, north, 4.5, 1.9, 1.6, 0, 0]],
    )
    truth = Truth(
        np.array([CAR, HIDDEN_CAR]),
        np.array([RECORDED.index(ObjectKind.CAR)] * 2),
        boxes,
        np.array([BRAKE | LEFT, 0]),
        np.array([0, 1]),
        np.array([-1, -1]),
        np.array([-1, -1]),
        ("", ""),
    )
    heads = np.array([[94.0, 75.0, 4.0, 0.3, 0.2, 0.66, 0.0], [106.0, 75.0, 4.0, 0.3, 0.2, 0.66, 0.0]])
    return Recorded(
        time_s=1.0,
        pose=np.array([100.0, 50.0, 0.0, north, 0, 0, 0, 0, 0]),
        sweep=LidarSweep(1.0, np.zeros((0, 4), np.float32)),
        imu=np.zeros(7),
        gnss=np.zeros(3),
        wheel_mps=0.0,
        truth=truth,
        lights=LightTruth(np.array([LIGHT]), np.array([0]), (heads,)),
        jpeg=file.getvalue(),
        instances=mask,
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("a", "b"):
        writer = RecordingWriter(tmp_path / "rec" / name, load_rig(), {})
        writer.add(recorded())
        writer.close()
    return tmp_path / "rec"


def only(crops: Crops, name: str) -> np.ndarray:
    return np.flatnonzero(crops.kind == KINDS.index(name))


def test_boxes_in_body_puts_box_ahead_of_ego() -> None:
    """A recorded box is ahead of an ego with its heading toward the box."""
    pose = np.array([100.0, 50.0, 0.0, np.pi / 2, 0, 0, 0, 0, 0])
    moved = boxes_in_body(pose, np.array([[98.0, 70.0, 0.8, 4.5, 1.9, 1.6, np.pi / 2]]))
    assert np.allclose(moved, [[20.0, 2.0, 0.8, 4.5, 1.9, 1.6, 0.0]])
    nose_down = boxes_in_body(np.array([0, 0, 0, 0, 0.1, 0, 0, 0, 0.0]), np.array([[10.0, 0, 0, 1, 1, 1, 0]]))
    assert nose_down[0, 2] > 0.9


def test_crops_visible_objects_have_kind_and_hidden_have_none(folder: Path) -> None:
    """Visible objects have their kind and lamps, and occluded ones are background."""
    pytest.importorskip("PIL")
    crops = crops_in([folder / "a"], jobs=1)
    [car] = only(crops, "car")
    assert crops.lamps[car].tolist() == [1, 1, 0, 0, 0]
    nothing = only(crops, NOTHING)
    assert len(nothing) >= 1
    assert (crops.lamps[nothing] == -1).all()
    assert crops.crops.shape[1:] == (96, 96, 3)


def test_a_head_of_a_light_that_something_covers_is_unseen(folder: Path) -> None:
    pytest.importorskip("PIL")
    crops = crops_in([folder / "a"], jobs=1)
    labels = crops.light[crops.light >= 0].tolist()
    assert sorted(labels) == [LIGHTS.index("red"), LIGHTS.index("unseen")]


def test_processes_read_the_same_crops(folder: Path) -> None:
    pytest.importorskip("PIL")
    one, two = crops_in([folder], jobs=1, seed=3), crops_in([folder], jobs=2, seed=3)
    assert sorted(one.kind.tolist()) == sorted(two.kind.tolist())
    assert one.crops.sum() == two.crops.sum()
    assert set(one.group.tolist()) == {0, 1}


def test_only_the_crops_of_flaggers_are_kept_if_wanted(folder: Path) -> None:
    pytest.importorskip("PIL")
    assert len(crops_in([folder], jobs=1)) > 0
    assert len(crops_in([folder], jobs=1, flaggers=True)) == 0


def test_recordings_are_not_torn_between_calibrating_and_scoring() -> None:
    group = np.array([0, 1, 1, 2, 0])
    half = halves(group)
    assert all(len(set(half[group == item].tolist())) == 1 for item in (0, 1, 2))
    assert half.any()
    assert not half.all()


def test_least_confidence_is_lowest_with_correct_answers() -> None:
    """The threshold is the lowest one from which on answers are right."""
    sure = np.linspace(0.6, 1.0, 200)
    right = sure > 0.8
    found = least_confidence(sure, right, 0.95)
    assert right[sure >= found].mean() >= 0.95
    assert right[sure >= found - 0.01].mean() < 0.95


def test_a_share_that_too_few_answers_show_is_never_reached() -> None:
    assert least_confidence(np.full(99, 0.9), np.ones(99, bool), 0.99) == NEVER
    assert least_confidence(np.full(100, 0.9), np.ones(100, bool), 0.99) == 0.9
    assert least_confidence(np.zeros(0), np.zeros(0, bool), 0.95) == NEVER
    assert least_confidence(np.full(100, 0.9), np.zeros(100, bool), 0.95) == NEVER


def test_each_half_is_scored_with_thresholds_of_the_other() -> None:
    """All lamps but brake lamps are unlabelled. In the first half, the sure answers are right; in the second, wrong."""
    n = 400
    first = np.arange(n) < n // 2
    lamps, lit = np.full((n, 5), -1), np.full((n, 5), -1)
    lamps[:, 0] = np.where(first, 1, 0)
    lit[:, 0] = lamps[:, 0]
    none, group = np.full(n, -1), np.where(first, 0, 1)
    crops = Crops(np.zeros((n, 1, 1, 3), np.uint8), np.zeros((n, 1), np.float32), *[none] * 7, group)
    crops = replace(crops, lamps=lamps, lit=lit)
    told = np.zeros((n, 5, 3))
    told[:, 0, 1] = 1.0
    logits = Logits(np.zeros((n, len(KINDS))), told, np.zeros((n, len(LIGHTS))), np.zeros((n, len(GESTURES))))
    card, scored = cross_check(logits, crops)
    # The first half allows the answer, which is always wrong in the second; the second forbids it in the first.
    assert scored["brake_lights"]["by_name"]["on"] == {
        "crops": 200,
        "found": 1.0,
        "answered": 0.0,
        "answers": 200,
        "right": 0.0,
    }
    assert card["least"]["lamps"]["brake_lights"]["on"] == NEVER, "half of all answers are wrong"


def test_answers_of_equal_confidence_stand_or_fall_together() -> None:
    right = np.array([True] * 30 + [False] * 30)
    assert least_confidence(np.full(60, 0.9), right, 0.95) == NEVER


def test_a_network_that_is_too_sure_is_cooled() -> None:
    random = np.random.default_rng(0)
    labels = random.integers(0, 2, 2000)
    wrong = random.random(2000) < 0.25
    logits = np.zeros((2000, 2))
    logits[np.arange(2000), np.where(wrong, 1 - labels, labels)] = 4.0
    # Right in 3 of 4: the odds are 3, so that the logits' difference should be log(3).
    assert temperature_of(logits, labels) == pytest.approx(4.0 / np.log(3.0), rel=0.1)


@pytest.mark.integration
def test_a_training_run_makes_a_network_that_the_runtime_loads(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("torch", reason="training needs torch")
    pytest.importorskip("onnx", reason="training needs onnx")
    from lab.perception.training.camera.crops_calibrate import calibrate
    from lab.perception.training.camera.crops_train import CropsTrainOptions, train

    train([folder], [folder], CropsTrainOptions(tmp_path / "out", minutes=1.0, batch=8, steps=3))
    network = CropNetwork(tmp_path / "out")
    told = network.run(np.zeros((2, 64, 64, 3), np.uint8), np.zeros((2, 10), np.float32))
    assert np.allclose(told.kind.sum(1), 1.0)
    assert told.lamps.shape == (2, 5, 3)
    card = tmp_path / "out" / "crops.json"
    marked = json.loads(card.read_text(encoding="utf-8"))
    marked["least"]["kind"]["car"], marked["least"]["gesture"]["stop"] = 0.123, 0.456
    card.write_text(json.dumps(marked), encoding="utf-8")
    least = calibrate(tmp_path / "out", [folder], only=("gesture",))["least"]
    assert (least["kind"]["car"], least["gesture"]["stop"]) == (0.123, NEVER), "there are no flaggers"
    card.write_text(card.read_text(encoding="utf-8").replace('"bag"', '"rug"'), encoding="utf-8")
    with pytest.raises(NetworkFileError, match=r"crops\.json.*kinds"):
        CropNetwork(tmp_path / "out")
