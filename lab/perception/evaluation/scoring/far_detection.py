"""Scores the detector of far vehicles: recall in the image, by distance."""

from __future__ import annotations

from typing import Any

import numpy as np

from lab.perception.evaluation.metrics.range_recall import RangeBin, recall_by_range
from lab.perception.evaluation.metrics.rectangles import matched, overlaps
from lab.perception.evaluation.scoring.samples import body_boxes, mask_id, visible_rectangles
from lab.perception.evaluation.scoring.scoring_part import (
    MissingGroundTruthError,
    ScoringInput,
    ScoringResult,
    StageTimer,
    percent,
    plain,
    table,
)
from stucksolver.scene.objects import MOTOR_VEHICLES
from stucksolver_perception.measurements import CameraFrame, Floats
from stucksolver_perception.recording import KINDS, Recorded
from stucksolver_perception.rig import CameraRig

BIN_M, FARTHEST_M = 25.0, 200.0
"""Width of a bin, and end of the last bin (m)."""
LEAST_OVERLAP = 0.3
"""Smallest intersection over union of a match. Ours: at 12 px, it is about 1.5 px on each side."""
LEAST_SHOWN = 0.3
"""Share of a vehicle's rectangle that its own pixels must fill for it to count. Ours."""
_ANYWAY = 0.1
"""Overlap with an uncounted object from which a detection is not a false positive. Ours."""


def score_far(source: ScoringInput) -> ScoringResult:
    """Score the detection of motor vehicles.

    Raises:
        NetworkFileError: A network cannot be used.
        MissingGroundTruthError: No image shows a vehicle.
    """
    from stucksolver_perception.camera.far_detector import FarDetector

    options = {} if source.camera_weights is None else {"folder": source.camera_weights}
    detector, watch = FarDetector(threads=source.threads, **options), StageTimer()
    ranges: list[float] = []
    hits: list[bool] = []
    right = wrong = 0
    for recording in source.recordings:
        rig = recording.rig.camera
        for tick in recording:
            picture = tick.picture()
            if picture is None or tick.instances is None:
                continue
            with watch("far"):
                found = detector.detect(CameraFrame(tick.time_s, picture), rig)
            wanted, away, other = _vehicles(tick, rig)
            boxes = rectangles(found)[found.label == 0]
            good, taken = matched(boxes, found.score[found.label == 0], wanted, LEAST_OVERLAP)
            spared = (overlaps(boxes, np.concatenate([wanted, other])) > _ANYWAY).any(axis=1)
            right, wrong = right + int(good.sum()), wrong + int((~good & ~spared).sum())
            ranges += away.tolist()
            hits += taken.tolist()
        source.say(f"far: {recording.folder.name}")
    if not ranges:
        raise MissingGroundTruthError("far: no image shows a vehicle. Collect drives with traffic")
    bins = recall_by_range(np.array(ranges), np.array(hits, np.bool_), BIN_M, FARTHEST_M)
    precision = right / (right + wrong) if right + wrong else None
    data = {"vehicles": len(ranges), "precision": precision, "bins": [{**plain(b), "recall": b.recall} for b in bins]}
    return ScoringResult(data, _page(len(ranges), precision, bins), watch.stages_ms)


def rectangles(found: Any) -> Floats:
    """Return left, top, right, bottom (px) of `FarDetections`, shape (n, 4)."""
    half = found.width / 2.0
    return np.stack([found.column - half, found.row - found.height, found.column + half, found.row], axis=1)


def _vehicles(tick: Recorded, rig: CameraRig) -> tuple[Floats, Floats, Floats]:
    """Return rectangles (px) and distances (m) of visible motor vehicles, and rectangles of all other objects."""
    from stucksolver_perception.camera.crops import corners_of

    boxes, rectangles_by_id = body_boxes(tick), visible_rectangles(tick)
    none = np.zeros((0, 4))
    if not len(boxes):
        return none, np.zeros(0), none
    column, row, ahead = (item.reshape(-1, 8) for item in rig.project(corners_of(boxes).reshape(-1, 3)))
    shown = np.stack([column.min(1), row.min(1), column.max(1), row.max(1)], axis=1)
    in_view = ahead.min(1) > 1.0
    counted = np.array(
        [bool(in_view[i]) and _is_counted(tick, i, shown[i], rectangles_by_id) for i in range(len(boxes))]
    )
    away = np.hypot(boxes[:, 0], boxes[:, 1])
    return shown[counted], away[counted], shown[in_view & ~counted]


def _is_counted(
    tick: Recorded, i: int, rectangle: Floats, rectangles_by_id: dict[int, tuple[int, int, int, int]]
) -> bool:
    assert tick.instances is not None
    actor = mask_id(int(tick.truth.actor_id[i]))
    if KINDS[int(tick.truth.kind[i])] not in MOTOR_VEHICLES or actor not in rectangles_by_id:
        return False
    left, top, right, bottom = rectangles_by_id[actor]
    own = int((tick.instances[top:bottom, left:right] == actor).sum())
    area = float((rectangle[2] - rectangle[0]) * (rectangle[3] - rectangle[1]))
    return own >= LEAST_SHOWN * area


def _page(vehicles: int, precision: float | None, bins: tuple[RangeBin, ...]) -> str:
    rows = [
        (f"{bin.nearest_m:.0f} to {bin.farthest_m:.0f} m", str(bin.objects), str(bin.found), percent(bin.recall))
        for bin in bins
    ]
    return (
        f"{vehicles} looks at motor vehicles with at least 6 x 4 visible pixels; {percent(precision)} of the "
        f"detections are right.\n\n{table(('distance', 'vehicles', 'found', 'recall'), rows)}\n"
    )
