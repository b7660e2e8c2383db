"""Scores the camera's networks: traffic lights, and kinds, lamps, doors and gestures of objects with given boxes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from lab.perception.evaluation.metrics.confusion import ConfusionMatrix, confusion
from lab.perception.evaluation.scoring.samples import body_boxes, in_body, mask_id, visible_rectangles
from lab.perception.evaluation.scoring.scoring_part import (
    MissingGroundTruthError,
    ScoringInput,
    ScoringResult,
    StageTimer,
    percent,
    plain,
    table,
)
from stucksolver.scene.objects import Gesture
from stucksolver.scene.surroundings import LightState
from stucksolver_perception.camera.crops import windows_of
from stucksolver_perception.measurements import CameraFrame, Floats
from stucksolver_perception.recording import KINDS, PARTS, Recorded
from stucksolver_perception.rig import CameraRig
from stucksolver_perception.visible_parts import VisibleParts

LIGHTS = (LightState.RED, LightState.YELLOW, LightState.GREEN, LightState.OFF)
"""Light states, in the order of their numbers in a recording."""
LEAST_FACING = 0.35
"""Least cosine between a head's direction and the direction to the lens. Ours.

A head in side view shows nothing.
"""
_YES, _NO = "on", "off"

Pair = tuple[str, str | None]


def score_lights(source: ScoringInput) -> ScoringResult:
    """Score single frames of visible lights that face the camera.

    Raises:
        NetworkFileError: A network cannot be used.
        MissingGroundTruthError: No image shows such a light.
    """
    from stucksolver_perception.camera.traffic_lights import LightReader

    reader, watch = LightReader(threads=source.threads, **_folder(source)), StageTimer()
    pairs: list[Pair] = []
    for recording in source.recordings:
        rig = recording.rig.camera
        for tick in recording:
            wanted = _lights(tick, rig)
            picture = tick.picture() if wanted else None
            if picture is None:
                continue
            with watch("lights"):
                readings = reader.read(CameraFrame(tick.time_s, picture), rig, [heads for _, heads in wanted])
            pairs += [(so.value, _answer_name(look[0])) for (so, _), look in zip(wanted, readings, strict=True)]
        source.say(f"lights: {recording.folder.name}")
    if not pairs:
        raise MissingGroundTruthError(
            "lights: no image shows a traffic light that faces the camera. Collect drives in towns"
        )
    matrix = confusion([light.value for light in LIGHTS], pairs)
    return ScoringResult(plain({**_summary(matrix), "confusion": matrix}), _light_page(matrix), watch.stages_ms)


def score_attributes(source: ScoringInput) -> ScoringResult:
    """Score single frames of visible objects with their true boxes.

    Raises:
        NetworkFileError: A network cannot be used.
        MissingGroundTruthError: No image shows an object.
    """
    from stucksolver_perception.camera.attributes import AttributeReader

    reader, watch = AttributeReader(threads=source.threads, **_folder(source)), StageTimer()
    kinds: list[Pair] = []
    lamps: dict[str, list[Pair]] = {name: [] for name in PARTS}
    gestures: list[Pair] = []
    for recording in source.recordings:
        rig = recording.rig.camera
        for tick in recording:
            picture = tick.picture()
            if picture is None:
                continue
            boxes, rectangles = body_boxes(tick), visible_rectangles(tick)
            shown = [i for i, item in enumerate(tick.truth.actor_id.tolist()) if mask_id(item) in rectangles]
            if not shown:
                continue
            with watch("attributes"):
                readings = reader.read(CameraFrame(tick.time_s, picture), rig, boxes[shown])
            parts, windows = VisibleParts(tick, rig, boxes), windows_of(rig, boxes)
            for i, answer in zip(shown, readings, strict=True):
                kind = KINDS[int(tick.truth.kind[i])]
                kinds.append((kind.value, None if answer.kind is None else answer.kind.value))
                visible = parts.get(i, windows.rectangle[i])
                for name, so in visible.lamps.items():
                    if so is not None:
                        lamps[name].append((_word(so), _word(getattr(answer, name))))
                if visible.gesture is not None:
                    gestures.append((visible.gesture.value, None if answer.gesture is None else answer.gesture.value))
        source.say(f"attributes: {recording.folder.name}")
    if not kinds:
        raise MissingGroundTruthError("attributes: no image shows an object. Collect drives with images")
    matrix = confusion([item.value for item in KINDS], kinds)
    each = {name: confusion((_YES, _NO), pairs) for name, pairs in lamps.items()}
    signals = confusion([gesture.value for gesture in Gesture], gestures)
    data = {
        "kind": {**_summary(matrix), "confusion": matrix},
        "lamps": {name: _lamp(item) for name, item in each.items()},
        "gesture": {**_summary(signals), "confusion": signals},
    }
    return ScoringResult(plain(data), _attribute_page(matrix, each, signals), watch.stages_ms)


def _lights(tick: Recorded, rig: CameraRig) -> list[tuple[LightState, Floats]]:
    """Return state and heads of each visible light with a head that faces the camera."""
    if tick.lights is None or tick.instances is None:
        return []
    rectangles = visible_rectangles(tick)
    found = []
    for light, state, heads in zip(tick.lights.light_id, tick.lights.state, tick.lights.heads, strict=True):
        if int(state) >= len(LIGHTS) or not len(heads) or mask_id(int(light)) not in rectangles:
            continue
        moved = in_body(tick, heads)
        if any(_is_shown(tick, int(light), head, rig) for head in moved):
            found.append((LIGHTS[int(state)], moved))
    return found


def _is_shown(tick: Recorded, light: int, head: Floats, rig: CameraRig) -> bool:
    """True if a head, shape (7,), faces the camera and is visible in the mask."""
    assert tick.instances is not None
    lens = rig.mount.to_vehicle()[:3, 3]
    # A head shows its lamps toward its negative y axis.
    showing = np.array([np.sin(head[6]), -np.cos(head[6])])
    to_lens = lens[:2] - head[:2]
    if float(showing @ to_lens) < LEAST_FACING * float(np.hypot(*to_lens)):
        return False
    wide = float(np.hypot(head[3], head[4]))
    corners = np.array([[head[0], head[1] + s * wide, head[2] + t * head[5]] for s in (-1, 1) for t in (-1, 1)])
    column, row, ahead = rig.project(corners)
    if ahead.min() <= 0.0:
        return False
    left, right = (int(np.clip(item, 0, rig.width_px)) for item in (column.min(), column.max() + 1))
    top, bottom = (int(np.clip(item, 0, rig.height_px)) for item in (row.min(), row.max() + 1))
    own = tick.instances[top:bottom, left:right] == mask_id(light)
    return bool(own.any(axis=0).sum() >= 3 and own.any(axis=1).sum() >= 6)


def _folder(source: ScoringInput) -> dict[str, Any]:
    return {} if source.camera_weights is None else {"folder": source.camera_weights}


def _answer_name(state: LightState) -> str | None:
    return None if state is LightState.UNKNOWN else state.value


def _word(on: bool | None) -> Any:
    return None if on is None else (_YES if on else _NO)


def _summary(matrix: ConfusionMatrix) -> dict[str, Any]:
    asked = int(matrix.counts.sum() + matrix.unknown.sum())
    return {"looks": asked, "answered": matrix.answered, "accuracy": matrix.accuracy}


def _lamp(matrix: ConfusionMatrix) -> dict[str, Any]:
    return {**_summary(matrix), "recall": matrix.recall(_YES), "precision": matrix.precision(_YES)}


def _light_page(matrix: ConfusionMatrix) -> str:
    red, green = (matrix.names.index(item.value) for item in (LightState.RED, LightState.GREEN))
    summary = f"{_line(matrix)} Red read as green: {matrix.counts[red, green]}."
    return f"{summary} Rows are the true states, columns the answers.\n\n{_matrix(matrix)}\n"


def _attribute_page(kinds: ConfusionMatrix, lamps: dict[str, ConfusionMatrix], gestures: ConfusionMatrix) -> str:
    there = [i for i in range(len(kinds.names)) if kinds.counts[i].sum() + kinds.unknown[i]]
    rows = [
        (
            kinds.names[i],
            str(int(kinds.counts[i].sum() + kinds.unknown[i])),
            percent(kinds.recall(kinds.names[i])),
            percent(kinds.precision(kinds.names[i])),
        )
        for i in there
    ]
    lamp_rows = [
        (
            name.replace("_", " "),
            str(int(lamp.counts.sum() + lamp.unknown.sum())),
            percent(lamp.answered),
            percent(lamp.accuracy),
            percent(lamp.recall(_YES)),
            percent(lamp.precision(_YES)),
        )
        for name, lamp in lamps.items()
    ]
    head = ("lamp", "looks", "answered", "accuracy of answers", "recall of on", "precision of on")
    return (
        f"Single looks with true boxes. {_line(kinds)}\n\n"
        f"{table(('kind', 'looks', 'recall', 'precision'), rows)}\n\n{table(head, lamp_rows)}\n\n"
        f"Gestures of flaggers: {_line(gestures)}\n\n{_matrix(gestures)}\n"
    )


def _line(matrix: ConfusionMatrix) -> str:
    asked = int(matrix.counts.sum() + matrix.unknown.sum())
    return f"{asked} looks, {percent(matrix.answered)} answered, {percent(matrix.accuracy)} of the answers are right."


def _matrix(matrix: ConfusionMatrix) -> str:
    rows: Sequence[Sequence[str]] = [
        (name, *(str(int(count)) for count in matrix.counts[i]), str(int(matrix.unknown[i])))
        for i, name in enumerate(matrix.names)
    ]
    return table(("", *matrix.names, "no answer"), rows)
