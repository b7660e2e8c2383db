"""Scores tracking on recordings without gaps: detector and tracker at 10 Hz, with true poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lab.perception.evaluation.metrics.amota import amota, best_threshold
from lab.perception.evaluation.metrics.clear_mot import MotCounts, TrackedFrame, assign, clear_mot
from lab.perception.evaluation.metrics.matching import ANY_LABEL, TruthObjects
from lab.perception.evaluation.scoring.samples import TURN_S, is_continuous, looks_of, reals_of, true_pose
from lab.perception.evaluation.scoring.scoring_part import (
    MissingGroundTruthError,
    ScoringInput,
    ScoringResult,
    StageTimer,
    figure,
    plain,
    table,
)
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.recording import Recorded, Recording

WITHIN_M = 2.0
"""Largest distance between a track and its object (m). Ours."""
FARTHEST_M = 60.0
"""Distance beyond which objects are not counted (m). Ours."""
_NOWHERE = np.zeros((0, 2))
"""No positions."""


@dataclass(frozen=True)
class LabelTracking:
    """Tracking scores of one label over all drives."""

    counts: MotCounts
    mota: float | None
    """MOTA of all tracks that the tracker reports."""
    best_mota: float | None
    """MOTA at the best score threshold, as in nuScenes."""
    best_at: float | None
    """The best score threshold."""
    motp_m: float | None
    recall: float | None
    amota: float | None
    velocity_rms_mps: float | None
    """RMS velocity error of tracks with an object (m/s)."""


@dataclass(frozen=True, eq=False)
class _TrackingFrame:
    """Tracks and objects at one time; tracks are rows of x, y (m), vx, vy (m/s) and score, in the local frame."""

    reals: TruthObjects
    real_xy: Any
    real_velocity: Any
    near: Any
    track_label: Any
    track_id: Any
    tracks: Any


def score_tracking(source: ScoringInput) -> ScoringResult:
    """Score tracking.

    Raises:
        NetworkFileError: A network cannot be used.
        MissingGroundTruthError: All recordings have gaps.
    """
    whole = [item for item in source.recordings if is_continuous(item)]
    if not whole:
        raise MissingGroundTruthError("tracking: all recordings have gaps. Collect some with --every 0")
    watch = StageTimer()
    drives = []
    for recording in whole:
        drives.append(_looks(source, recording, watch))
        source.say(f"tracking: {recording.folder.name}")
    by_label = {name: _of_label(drives, label) for label, name in enumerate(LABELS)}
    total = sum((tracking.counts for tracking in by_label.values()), MotCounts())
    known = [tracking.amota for tracking in by_label.values() if tracking.amota is not None]
    data = {
        "drives": len(whole),
        "counts": total,
        "mota": total.mota,
        "motp_m": total.motp_m,
        "amota": float(np.mean(known)) if known else None,
        "by_label": by_label,
    }
    return ScoringResult(plain(data), _page(data), watch.stages_ms)


def _looks(source: ScoringInput, recording: Recording, watch: StageTimer) -> list[_TrackingFrame]:
    from stucksolver_perception.free_space import FreeSpace
    from stucksolver_perception.lidar.detector import LidarDetector
    from stucksolver_perception.lidar.sweeps import SweepBuffer
    from stucksolver_perception.tracking import ObjectTracker

    options = {} if source.lidar_weights is None else {"folder": source.lidar_weights}
    detector = LidarDetector(**options)
    buffer, tracker, looks = SweepBuffer(), ObjectTracker(recording.rig), []
    for ticks in looks_of(recording):
        for each in ticks:
            buffer.add(each.sweep, true_pose(each))
        tick = ticks[-1]
        pose = true_pose(tick)
        points = buffer.gather(pose)
        detections = detector.detect(points, tick.time_s)
        with watch("visibility"):
            space = FreeSpace.from_points(points[points[:, 4] <= TURN_S], recording.rig.lidar)
        with watch("tracking"):
            tracks = tracker.update(detections, pose, space)
        looks.append(_look(tick, reals_of(tick, points), tracks))
    return looks


def _look(tick: Recorded, reals: TruthObjects, tracks: Sequence[Any]) -> _TrackingFrame:
    rows = np.array([(t.x_m, t.y_m, t.vx_mps, t.vy_mps, t.confidence) for t in tracks]).reshape(-1, 5)
    away = np.hypot(*reals.center[:, :2].T)
    is_near = np.hypot(rows[:, 0] - tick.pose[0], rows[:, 1] - tick.pose[1]) < FARTHEST_M
    return _TrackingFrame(
        reals=reals,
        real_xy=tick.truth.boxes[:, :2],
        real_velocity=tick.truth.boxes[:, 7:9],
        near=away < FARTHEST_M,
        track_label=np.array([t.label for t in tracks], np.int64)[is_near],
        track_id=np.array([t.id for t in tracks], np.int64)[is_near],
        tracks=rows[is_near],
    )


def _of_label(drives: Sequence[Sequence[_TrackingFrame]], label: int) -> LabelTracking:
    frames = [_frames(looks, label) for looks in drives]
    counts = sum((clear_mot(frame, WITHIN_M) for frame in frames), MotCounts())
    errors = [error for looks, run in zip(drives, frames, strict=True) for error in _velocity_errors(looks, run, label)]
    best = best_threshold(frames, WITHIN_M)
    return LabelTracking(
        counts=counts,
        mota=counts.mota,
        best_mota=None if best is None else best[1].mota,
        best_at=None if best is None else best[0],
        motp_m=counts.motp_m,
        recall=counts.recall,
        amota=amota(frames, WITHIN_M),
        velocity_rms_mps=float(np.sqrt(np.mean(np.square(errors)))) if errors else None,
    )


def _frames(looks: Sequence[_TrackingFrame], label: int) -> list[TrackedFrame]:
    """Return the frames of one label. Any track may match objects without a label."""
    sums: dict[int, list[float]] = {}
    for look in looks:
        for track, score in zip(look.track_id.tolist(), look.tracks[:, 4].tolist(), strict=True):
            sums.setdefault(track, []).append(score)
    means = {track: float(np.mean(scores)) for track, scores in sums.items()}
    frames = []
    for look in looks:
        mine = look.track_label == label
        reals = look.reals
        wanted = (reals.label == label) | (reals.label == ANY_LABEL)
        frames.append(
            TrackedFrame(
                object_id=reals.identity[wanted],
                object_xy=look.real_xy[wanted],
                counted=(reals.counted & look.near & (reals.label == label))[wanted],
                track_id=look.track_id[mine],
                track_xy=look.tracks[mine, :2] if mine.any() else _NOWHERE,
                score=np.array([means[item] for item in look.track_id[mine].tolist()]),
            )
        )
    return frames


def _velocity_errors(looks: Sequence[_TrackingFrame], frames: Sequence[TrackedFrame], label: int) -> list[float]:
    last: dict[int, int] = {}
    errors = []
    for look, frame in zip(looks, frames, strict=True):
        wanted = np.flatnonzero((look.reals.label == label) | (look.reals.label == ANY_LABEL))
        mine = np.flatnonzero(look.track_label == label)
        for i, j, _ in assign(frame, last, WITHIN_M):
            last[int(frame.object_id[i])] = int(frame.track_id[j])
            if frame.counted[i]:
                off = look.tracks[mine[j], 2:4] - look.real_velocity[wanted[i]]
                errors.append(float(np.hypot(*off)))
    return errors


def _page(data: dict[str, Any]) -> str:
    head = (
        "class",
        "objects",
        "MOTA",
        "best MOTA",
        "at",
        "AMOTA",
        "MOTP m",
        "recall",
        "switches",
        "false",
        "velocity RMS m/s",
    )
    total = data["counts"]
    rows = [
        (
            name,
            str(item.counts.objects),
            figure(item.mota),
            figure(item.best_mota),
            figure(item.best_at, 2),
            figure(item.amota),
            figure(item.motp_m, 2),
            figure(item.recall),
            str(item.counts.switches),
            str(item.counts.false_positives),
            figure(item.velocity_rms_mps, 2),
        )
        for name, item in data["by_label"].items()
    ]
    return (
        f"{data['drives']} drives, objects up to {FARTHEST_M:.0f} m, matched within {WITHIN_M:.0f} m: "
        f"MOTA {figure(total.mota)}, AMOTA {figure(data['amota'])}, {total.switches} identity switches.\n\n"
        f"{table(head, rows)}\n"
    )
