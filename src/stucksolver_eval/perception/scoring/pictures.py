"""Scores the camera's readers: traffic lights, and kinds, lamps and doors of objects with given boxes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from stucksolver.perception.measurements import CameraFrame, Floats
from stucksolver.perception.recording import KINDS, Recorded
from stucksolver.perception.rig import CameraRig
from stucksolver.scene.objects import MOTOR_VEHICLES, ObjectKind
from stucksolver.scene.surroundings import LightState
from stucksolver_eval.perception.metrics.confusion import Confusion, confusion
from stucksolver_eval.perception.scoring.part import Given, NothingToScore, Part, Watch, percent, plain, table
from stucksolver_eval.perception.scoring.samples import body_boxes, in_body, mask_id, seen_rectangles

LIGHTS = (LightState.RED, LightState.YELLOW, LightState.GREEN, LightState.OFF)
"""Light states, in the order of their numbers in a recording."""
LEAST_FACING = 0.35
"""Least cosine between a head's direction and the direction to the lens: a head seen from the side shows nothing."""
LAMPS_SHARE, LAMPS_PX = 0.35, 16
"""Lamps are legible if a vehicle's pixels fill this share of its rectangle, and the rectangle has this size."""
_BRAKE, _LEFT, _RIGHT, _SPECIAL = 8, 32, 16, 512 | 1024
"""Bits of `carla.VehicleLightState`."""
LAMPS = ("brake_lights", "left_blinker", "right_blinker", "emergency_lights", "door_open")
_YES, _NO = "on", "off"

Pair = tuple[str, str | None]


def score_lights(given: Given) -> Part:
    """Score single looks at visible lights that face the camera. Raises `WeightsError` and `NothingToScore`."""
    from stucksolver.perception.camera.lights import LightReader

    reader, watch = LightReader(threads=given.threads, **_folder(given)), Watch()
    pairs: list[Pair] = []
    for recording in given.recordings:
        rig = recording.rig.camera
        for tick in recording:
            wanted = _lights(tick, rig)
            picture = tick.picture() if wanted else None
            if picture is None:
                continue
            with watch("lights"):
                told = reader.read(CameraFrame(tick.time_s, picture), rig, [heads for _, heads in wanted])
            pairs += [(so.value, _said(look[0])) for (so, _), look in zip(wanted, told, strict=True)]
        given.say(f"lights: {recording.folder.name}")
    if not pairs:
        raise NothingToScore("lights: no image shows a traffic light that faces the camera; collect drives in towns")
    matrix = confusion([one.value for one in LIGHTS], pairs)
    return Part(plain({**_summary(matrix), "confusion": matrix}), _light_page(matrix), watch.stages_ms)


def score_attributes(given: Given) -> Part:
    """Score single looks at visible objects with their true boxes. Raises `WeightsError` and `NothingToScore`."""
    from stucksolver.perception.camera.attributes import AttributeReader

    reader, watch = AttributeReader(threads=given.threads, **_folder(given)), Watch()
    kinds: list[Pair] = []
    lamps: dict[str, list[Pair]] = {name: [] for name in LAMPS}
    for recording in given.recordings:
        rig = recording.rig.camera
        for tick in recording:
            picture = tick.picture()
            if picture is None:
                continue
            boxes, seen = body_boxes(tick), seen_rectangles(tick)
            shown = [i for i, one in enumerate(tick.truth.actor_id.tolist()) if mask_id(one) in seen]
            if not shown:
                continue
            with watch("attributes"):
                told = reader.read(CameraFrame(tick.time_s, picture), rig, boxes[shown])
            for i, answer in zip(shown, told, strict=True):
                kind = KINDS[int(tick.truth.kind[i])]
                kinds.append((kind.value, None if answer.kind is None else answer.kind.value))
                for name, so in true_lamps(tick, i, boxes[i], seen).items():
                    lamps[name].append((_word(so), _word(getattr(answer, name))))
        given.say(f"attributes: {recording.folder.name}")
    if not kinds:
        raise NothingToScore("attributes: no image shows an object; collect drives with images")
    matrix = confusion([one.value for one in KINDS], kinds)
    each = {name: confusion((_YES, _NO), pairs) for name, pairs in lamps.items()}
    data = {"kind": {**_summary(matrix), "confusion": matrix}, "lamps": {k: _lamp(v) for k, v in each.items()}}
    return Part(plain(data), _attribute_page(matrix, each), watch.stages_ms)


def true_lamps(tick: Recorded, i: int, box: Floats, seen: dict[int, tuple[int, int, int, int]]) -> dict[str, bool]:
    """Return the lamps and doors of an object that are visible, with True if on or open.

    Args:
        tick: The recorded tick.
        i: Index of the object in the truth.
        box: Shape (7,): its box in the frame of the ego's body (m, rad).
        seen: Visible rectangles by mask id (px); see `seen_rectangles`.
    """
    kind, flags, doors = KINDS[int(tick.truth.kind[i])], int(tick.truth.lamps[i]), int(tick.truth.doors[i])
    actor = mask_id(int(tick.truth.actor_id[i]))
    left, top, right, bottom = seen[actor]
    assert tick.instances is not None
    part = tick.instances[top:bottom, left:right]
    enough = max(right - left, bottom - top) >= LAMPS_PX and (part == actor).mean() >= LAMPS_SHARE
    if kind not in MOTOR_VEHICLES or not enough:
        return {}
    # 0: the lens is ahead of the vehicle; 90: to its left.
    bearing = float(np.degrees(np.angle(np.exp(1j * (np.arctan2(-box[1], -box[0]) - box[6])))))
    found: dict[str, bool] = {}
    if flags >= 0:
        if abs(bearing) > 100.0:
            found["brake_lights"] = bool(flags & _BRAKE)
        if not -110.0 < bearing < -70.0:
            found["left_blinker"] = bool(flags & _LEFT)
        if not 70.0 < bearing < 110.0:
            found["right_blinker"] = bool(flags & _RIGHT)
        if kind in (ObjectKind.EMERGENCY, ObjectKind.SCHOOL_BUS):
            found["emergency_lights"] = bool(flags & _SPECIAL)
    if doors >= 0:
        found["door_open"] = bool(doors)
    return found


def _lights(tick: Recorded, rig: CameraRig) -> list[tuple[LightState, Floats]]:
    """Return state and heads of each visible light with a head that faces the camera."""
    if tick.lights is None or tick.instances is None:
        return []
    seen = seen_rectangles(tick)
    found = []
    for light, state, heads in zip(tick.lights.light_id, tick.lights.state, tick.lights.heads, strict=True):
        if int(state) >= len(LIGHTS) or not len(heads) or mask_id(int(light)) not in seen:
            continue
        moved = in_body(tick, heads)
        if any(_is_shown(tick, int(light), head, rig) for head in moved):
            found.append((LIGHTS[int(state)], moved))
    return found


def _is_shown(tick: Recorded, light: int, head: Floats, rig: CameraRig) -> bool:
    """Return True if a head, shape (7,), faces the camera and is visible in the mask."""
    assert tick.instances is not None
    lens = rig.mount.to_vehicle()[:3, 3]
    # A head shows its lamps towards its negative y axis.
    showing = np.array([np.sin(head[6]), -np.cos(head[6])])
    to_lens = lens[:2] - head[:2]
    if float(showing @ to_lens) < LEAST_FACING * float(np.hypot(*to_lens)):
        return False
    wide = float(np.hypot(head[3], head[4]))
    corners = np.array([[head[0], head[1] + s * wide, head[2] + t * head[5]] for s in (-1, 1) for t in (-1, 1)])
    column, row, ahead = rig.project(corners)
    if ahead.min() <= 0.0:
        return False
    left, right = (int(np.clip(one, 0, rig.width_px)) for one in (column.min(), column.max() + 1))
    top, bottom = (int(np.clip(one, 0, rig.height_px)) for one in (row.min(), row.max() + 1))
    own = tick.instances[top:bottom, left:right] == mask_id(light)
    return bool(own.any(axis=0).sum() >= 3 and own.any(axis=1).sum() >= 6)


def _folder(given: Given) -> dict[str, Any]:
    return {} if given.camera_weights is None else {"folder": given.camera_weights}


def _said(state: LightState) -> str | None:
    return None if state is LightState.UNKNOWN else state.value


def _word(on: bool | None) -> Any:
    return None if on is None else (_YES if on else _NO)


def _summary(matrix: Confusion) -> dict[str, Any]:
    asked = int(matrix.counts.sum() + matrix.unknown.sum())
    return {"looks": asked, "answered": matrix.answered, "accuracy": matrix.accuracy}


def _lamp(matrix: Confusion) -> dict[str, Any]:
    return {**_summary(matrix), "recall": matrix.recall(_YES), "precision": matrix.precision(_YES)}


def _light_page(matrix: Confusion) -> str:
    red, green = (matrix.names.index(one.value) for one in (LightState.RED, LightState.GREEN))
    said = f"{_line(matrix)} Red read as green: {matrix.counts[red, green]}."
    return f"{said} Rows are the true states, columns the answers.\n\n{_matrix(matrix)}\n"


def _attribute_page(kinds: Confusion, lamps: dict[str, Confusion]) -> str:
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
            str(int(one.counts.sum() + one.unknown.sum())),
            percent(one.answered),
            percent(one.accuracy),
            percent(one.recall(_YES)),
            percent(one.precision(_YES)),
        )
        for name, one in lamps.items()
    ]
    head = ("lamp", "looks", "answered", "accuracy of answers", "recall of on", "precision of on")
    return (
        f"Single looks with true boxes. {_line(kinds)}\n\n"
        f"{table(('kind', 'looks', 'recall', 'precision'), rows)}\n\n{table(head, lamp_rows)}\n"
    )


def _line(matrix: Confusion) -> str:
    asked = int(matrix.counts.sum() + matrix.unknown.sum())
    return f"{asked} looks, {percent(matrix.answered)} answered, {percent(matrix.accuracy)} of the answers are right."


def _matrix(matrix: Confusion) -> str:
    rows: Sequence[Sequence[str]] = [
        (name, *(str(int(one)) for one in matrix.counts[i]), str(int(matrix.unknown[i])))
        for i, name in enumerate(matrix.names)
    ]
    return table(("", *matrix.names, "no answer"), rows)
