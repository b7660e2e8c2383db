"""What keeps the detector from starting, and that it says so."""

import hashlib
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stucksolver_perception.lidar.detector import CARD, VERSION, WEIGHTS, LidarDetector
from stucksolver_perception.lidar.grid import GRID
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.network_files import NetworkFileError

IDENTITY = bytes.fromhex(
    "08093a370a100a017812017922084964656e746974791201675a0f0a0178120a0a08080112040a020801620f0a0179120a0a08080112040a02"
    "080142040a001012"
)
"""The smallest network that onnxruntime loads: it returns its input."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / WEIGHTS).write_bytes(IDENTITY)
    write_card(tmp_path)
    return tmp_path


def write_card(folder: Path, **changes: Any) -> None:
    ones = [1.0] * len(LABELS)
    card = {"version": VERSION, "sha256": hashlib.sha256(IDENTITY).hexdigest(), "labels": LABELS}
    card |= {"grid": asdict(GRID), "slope": ones, "shift": ones, "least_score": ones, **changes}
    (folder / CARD).write_text(json.dumps(card), encoding="utf-8")


def test_a_network_and_its_card_are_enough(folder: Path) -> None:
    assert LidarDetector(folder).grid == GRID


def test_no_points_are_no_detections(folder: Path) -> None:
    found = LidarDetector(folder).detect(np.zeros((0, 5), np.float32), 3.0)
    assert (len(found), found.time_s, found.velocity.shape) == (0, 3.0, (0, 2))


@pytest.mark.parametrize("name", [WEIGHTS, CARD])
def test_a_missing_file_is_named_with_the_remedy(folder: Path, name: str) -> None:
    (folder / name).unlink()
    with pytest.raises(NetworkFileError, match=f"{name}.*reinstall") as caught:
        LidarDetector(folder)
    assert "\n" not in str(caught.value)


def test_damaged_weights_are_refused(folder: Path) -> None:
    (folder / WEIGHTS).write_bytes(IDENTITY[:-1] + b"\x00")
    with pytest.raises(NetworkFileError, match=f"{WEIGHTS}.*damaged"):
        LidarDetector(folder)


def test_a_damaged_card_is_refused(folder: Path) -> None:
    (folder / CARD).write_text("{", encoding="utf-8")
    with pytest.raises(NetworkFileError, match=f"{CARD}.*damaged"):
        LidarDetector(folder)


def test_another_version_is_refused(folder: Path) -> None:
    write_card(folder, version=VERSION + 1)
    with pytest.raises(NetworkFileError, match=f"version {VERSION + 1}; expected version {VERSION}"):
        LidarDetector(folder)


def test_a_network_for_other_labels_is_refused(folder: Path) -> None:
    write_card(folder, labels=["car", "tram"])
    with pytest.raises(NetworkFileError, match="trained for car, tram"):
        LidarDetector(folder)


@pytest.mark.parametrize("changes", [{"grid": {"rows_of": 3}}, {"slope": 1.0}, {"least_score": [0.1]}])
def test_a_card_with_other_fields_is_refused(folder: Path, changes: dict[str, Any]) -> None:
    write_card(folder, **changes)
    with pytest.raises(NetworkFileError, match=CARD):
        LidarDetector(folder)
