"""How often the far detector finds vehicles of which something nearer covers a part, and what sight makes of it."""

from __future__ import annotations

import json

import numpy as np
import pytest

from lab.perception.training.camera.far_data import MARGIN_ROWS, MOST_BOXES, Strips
from lab.perception.training.camera.far_evaluate import check_part, written_part
from stucksolver_perception.camera.camera_sight_distance import SightModel
from stucksolver_perception.camera.horizon_strip import LABELS, STRIDE, STRIP_ROWS
from stucksolver_perception.measurements import Pixels
from stucksolver_perception.network_files import DATA
from stucksolver_perception.rig import load_rig

TOP, WIDTH = 350, 1600
BOX = (600.0, 420.0, 624.0, 440.0)
"""Left, top, right, bottom (px)."""


def strips(*shares: float) -> Strips:
    """Two images half a second apart with one vehicle at 80 m for each share of it that is seen, side by side."""
    boxes = np.full((2, MOST_BOXES, 10), np.nan, np.float32)
    for k, share in enumerate(shares):
        left, top, right, bottom = BOX
        boxes[:, k] = (0.0, left + 100.0 * k, top, right + 100.0 * k, bottom, share, 80.0, 1.0, 7.0 + k, 1.9)
    rgb = np.full((2, STRIP_ROWS + 2 * MARGIN_ROWS, WIDTH, 3), 120, np.uint8)
    drive, tops = np.zeros(2, np.int64), np.full(2, TOP - MARGIN_ROWS)
    return Strips(rgb, tops, boxes, np.array([1.0, 1.5]), drive, (("Town02", "day"),), load_rig().camera)


class Finder:
    """A network that finds the vehicle in these images."""

    def __init__(self, *found: bool) -> None:
        self._found = list(found)

    def __call__(self, strip: Pixels) -> tuple[np.ndarray, np.ndarray]:
        shape = STRIP_ROWS // STRIDE, WIDTH // STRIDE
        peaks, rest = np.zeros((len(LABELS), *shape), np.float32), np.zeros((6, *shape), np.float32)
        if self._found.pop(0):
            left, top, right, bottom = BOX
            x, y = (left + right) / 2 / STRIDE, ((top + bottom) / 2 - TOP) / STRIDE
            cell = int(y), int(x)
            peaks[0][cell] = 0.99
            size = np.log((right - left) / STRIDE), np.log((bottom - top) / STRIDE)
            rest[:, cell[0], cell[1]] = (
                *size, x - cell[1] - 0.5, y - cell[0] - 0.5, (bottom - TOP) / STRIDE - cell[0] - 0.5, 9.0
            )  # fmt: skip
        return peaks, rest


def card() -> dict[str, object]:
    told: dict[str, object] = json.loads((DATA / "far.json").read_text(encoding="utf-8"))
    return told


def total(part: dict[str, object], place: int) -> list[int]:
    return np.sum(part["recall"], axis=0)[place].tolist()  # type: ignore[call-overload, no-any-return]


def test_only_vehicles_seen_in_part_count() -> None:
    part = check_part(Finder(True, False), strips(0.5, 0.9), card())
    assert total(part, 2) == [1, 2], "the bin from 75 m"
    assert total(part, 1) == total(part, 3) == [0, 0]
    assert "0.500 (2)" in written_part({"part": part})


@pytest.mark.parametrize(
    ("found", "again"), [((False, False), [1, 1]), ((False, True), [0, 1]), ((True, True), [0, 0])]
)
def test_misses_that_a_second_look_repeats_are_counted(found: tuple[bool, bool], again: list[int]) -> None:
    assert check_part(Finder(*found), strips(0.5), card())["repeated_miss"] == again


def test_sight_model_reads_recall_of_partly_visible_vehicles() -> None:
    """The recall for partly visible vehicles is read from the detector's card."""
    told, look, away = card(), np.array([120.0, 30.0]), np.array([80.0])
    told.pop("part", None)
    assert SightModel.from_card(told).miss_at(away, look, part=True) == 1.0
    classes = len(told["recall"]["vehicle"])  # type: ignore[index]
    told["part"] = {"recall": [[[190, 200]] * 8] * classes, "repeated_miss": [5, 10]}
    model = SightModel.from_card(told)
    assert 0.05 < float(model.miss_at(away, look, part=True)[0]) < 0.08
    assert 0.5 < model.again_part < 0.7
