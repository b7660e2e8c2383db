"""A drive is recorded on the embedded simulator: the truth lies where the sensors see it."""

from __future__ import annotations

import io
import itertools
from pathlib import Path

import numpy as np
import pytest

from lab.perception.evaluation.scoring.samples import body_boxes, is_continuous, mask_id, points_in, visible_rectangles
from lab.perception.recording.collect_recordings import CollectSpec, collect
from stucksolver.scene import ObjectKind
from stucksolver_perception.recording import GESTURES, KINDS, Recorded, recordings

pytestmark = [pytest.mark.integration, pytest.mark.release]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Five seconds behind an accident, every tick of them."""
    out = tmp_path_factory.mktemp("recordings")
    found = collect(_spec(out), io.StringIO())
    assert (found.done, found.failed) == (1, ())
    return out


@pytest.fixture(scope="module")
def ticks(folder: Path) -> list[Recorded]:
    (only,) = recordings(folder)
    assert is_continuous(only)
    return list(only)


def _spec(out: Path) -> CollectSpec:
    return CollectSpec(out, suite="dev", only=("1000",), jobs=1, limit_s=5.0, every_s=0.0)


def test_near_bodies_have_points_in_their_boxes(ticks: list[Recorded]) -> None:
    empty = cars = 0
    for before, now in itertools.pairwise(ticks):
        turn = np.concatenate([before.sweep.points[:, :3], now.sweep.points[:, :3]])
        boxes = body_boxes(now)
        near = np.hypot(boxes[:, 0], boxes[:, 1]) < 15.0
        near &= np.isin(now.truth.kind, [KINDS.index(ObjectKind.CAR)])
        counts = points_in(boxes[near], turn)
        cars, empty = cars + len(counts), empty + int((counts < 3).sum())
    assert cars > 20
    assert empty < 0.3 * cars


def test_what_the_mask_shows_lies_in_the_boxes_rectangle(ticks: list[Recorded]) -> None:
    (recorded, *_) = [tick for tick in ticks if tick.instances is not None]
    seen, boxes = visible_rectangles(recorded), body_boxes(recorded)
    from stucksolver_perception.camera.crops import corners_of
    from stucksolver_perception.rig import load_rig

    column, row, ahead = load_rig().camera.project(corners_of(boxes).reshape(-1, 3))
    shown = [i for i, item in enumerate(recorded.truth.actor_id.tolist()) if mask_id(item) in seen]
    whole = [i for i in shown if ahead.reshape(-1, 8)[i].min() > 1.0]
    assert whole
    for i in whole:
        left, top, right, bottom = seen[mask_id(int(recorded.truth.actor_id[i]))]
        columns, rows = column.reshape(-1, 8)[i], row.reshape(-1, 8)[i]
        assert columns.min() - 2.0 <= left and right <= columns.max() + 2.0
        assert rows.min() - 2.0 <= top and bottom <= rows.max() + 2.0


def test_fixes_compass_and_wheels_are_those_of_the_ego(ticks: list[Recorded]) -> None:
    off = np.array([tick.gnss[:2] - tick.pose[:2] for tick in ticks])
    assert np.abs(off.mean(axis=0)).max() < 0.5
    assert 0.3 < off.std() < 0.8
    assert max(abs(np.angle(np.exp(1j * (tick.imu[6] - tick.pose[3])))) for tick in ticks) < 0.02
    assert max(abs(tick.wheel_mps - tick.pose[6]) for tick in ticks) < 0.3


def test_a_route_that_is_recorded_is_not_driven_again(folder: Path) -> None:
    before = {file: file.stat().st_mtime_ns for file in folder.glob("*/*.npz")}
    told = io.StringIO()
    assert collect(_spec(folder), told).done == 1
    assert {file: file.stat().st_mtime_ns for file in folder.glob("*/*.npz")} == before
    assert "1 of 1 routes are recorded already" in told.getvalue()


def test_the_flaggers_of_a_crowd_signal(tmp_path: Path) -> None:
    spec = CollectSpec(tmp_path, towns=("demo_town",), drives=2, jobs=2, limit_s=4.0, seed=5)
    assert collect(spec, io.StringIO()).failed == ()
    told = set()
    for recording in recordings(tmp_path):
        for tick in recording:
            is_flagger = tick.truth.kind == KINDS.index(ObjectKind.FLAGGER)
            told |= {GESTURES[item] for item in tick.truth.gesture[is_flagger].tolist()}
            assert (tick.truth.gesture[~is_flagger] < 0).all()
    assert len(told) >= 2
