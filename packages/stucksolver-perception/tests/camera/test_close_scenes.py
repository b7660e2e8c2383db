"""Staged scenes for the crop network, recorded in carlette."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PIL", reason="images need the extra `perception`")

from lab.perception.recording.close_scenes import CloseDrive, record
from stucksolver.scene import ObjectKind
from stucksolver.scene.objects import Gesture
from stucksolver_perception.camera.crops import windows_of
from stucksolver_perception.recording import GESTURES, KINDS, PARTS, Recorded, Recording
from stucksolver_perception.vehicle_frame import boxes_in_body
from stucksolver_perception.visible_parts import VisibleParts

LIT = {"brake_lights": 8, "left_blinker": 32, "right_blinker": 16, "emergency_lights": 512}
SCENES, SIGNALLED = 3, 6


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> list[list[Recorded]]:
    """The images of each scene: as it is, with each part switched, and in rain if there is any."""
    folder: Path = tmp_path_factory.mktemp("close")
    count = record(CloseDrive(folder / "one", "demo_town", None, 3, SCENES))
    ticks = list(Recording(folder / "one"))
    assert len(ticks) == count
    each = count // SCENES
    assert each in (len(PARTS) + 1, len(PARTS) + 2)
    return [ticks[k * each : (k + 1) * each] for k in range(SCENES)]


def of(tick: Recorded, actor: int) -> int:
    [row] = np.flatnonzero(tick.truth.actor_id == actor)
    return int(row)


@pytest.mark.release
@pytest.mark.integration
def test_each_image_has_one_part_of_the_vehicles_switched(scenes: list[list[Recorded]]) -> None:
    switched = 0
    for first, *others in scenes:
        for part, other in zip(PARTS, others, strict=False):
            for actor, shown in zip(first.truth.actor_id.tolist(), first.truth.shown.tolist(), strict=True):
                if shown < 0 or not shown & 1 << PARTS.index(part):
                    continue
                before, after = (
                    (int(item.truth.lamps[of(item, actor)]), int(item.truth.doors[of(item, actor)]))
                    for item in (first, other)
                )
                switched += 1
                if part == "door_open":
                    assert (before[0], bool(before[1])) == (after[0], not after[1])
                else:
                    assert (before[0] ^ LIT[part], before[1]) == after
    assert switched >= 5


@pytest.mark.integration
def test_a_part_is_shown_where_the_vehicles_pixels_change(scenes: list[list[Recorded]]) -> None:
    for first, *others in scenes:
        assert first.instances is not None
        for part, other in zip(PARTS, others, strict=False):
            differs = np.abs(first.picture().astype(int) - other.picture()).max(axis=2) > 40
            for actor, shown in zip(first.truth.actor_id.tolist(), first.truth.shown.tolist(), strict=True):
                if shown >= 0 and shown & 1 << PARTS.index(part) and part != "door_open":
                    assert (differs & (first.instances == actor % 65536)).any(), (part, actor)


@pytest.mark.integration
def test_things_are_where_they_were_and_flaggers_signal(scenes: list[list[Recorded]]) -> None:
    signals = set()
    for first, *others in scenes:
        for other in others:
            np.testing.assert_array_equal(first.truth.actor_id, other.truth.actor_id)
            np.testing.assert_array_equal(first.truth.boxes, other.truth.boxes)
            np.testing.assert_array_equal(first.truth.shown, other.truth.shown)
        is_flagger = first.truth.kind == KINDS.index(ObjectKind.FLAGGER)
        assert ((first.truth.gesture >= 0) == is_flagger).all()
        signals |= {GESTURES[item] for item in first.truth.gesture[is_flagger].tolist()}
    assert signals or not any((scene[0].truth.kind == KINDS.index(ObjectKind.FLAGGER)).any() for scene in scenes)


@pytest.mark.integration
def test_scenes_for_gestures_have_many_flaggers_whose_paddles_are_where_they_are_looked_for(tmp_path: Path) -> None:
    count = record(CloseDrive(tmp_path / "signals", "demo_town", None, 5, SIGNALLED, gestures=True))
    recording = Recording(tmp_path / "signals")
    ticks = list(recording)
    assert len(ticks) == count == SIGNALLED, "one image of each scene"
    seen: list[Gesture | None] = []
    for tick in ticks:
        boxes = boxes_in_body(tick.pose, tick.truth.boxes[:, [0, 1, 2, 4, 5, 6, 3]])
        windows = windows_of(recording.rig.camera, boxes)
        parts = VisibleParts(tick, recording.rig.camera, boxes)
        flaggers = windows.usable & (tick.truth.kind == KINDS.index(ObjectKind.FLAGGER))
        seen += [parts.get(i, windows.rectangle[i]).gesture for i in np.flatnonzero(flaggers).tolist()]
    with_paddle = [item for item in seen if item not in (None, Gesture.NONE)]
    assert len(with_paddle) >= SIGNALLED, seen
