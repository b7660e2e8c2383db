"""Scores the localizer on recordings without gaps."""

from __future__ import annotations

from typing import Any

import numpy as np

from lab.perception.evaluation.metrics.pose_errors import PoseErrors, pose_errors, rms
from lab.perception.evaluation.scoring.samples import is_continuous
from lab.perception.evaluation.scoring.scoring_part import (
    MissingGroundTruthError,
    ScoringInput,
    ScoringResult,
    StageTimer,
    figure,
    percent,
    plain,
    table,
)
from stucksolver_perception.measurements import GnssFix, ImuSample, WheelSpeed
from stucksolver_perception.recording import Recorded, Recording

SETTLE_S = 5.0
"""Time after the start before which estimates are not counted (s). Ours; the filter starts from a single fix."""


def score_localization(source: ScoringInput) -> ScoringResult:
    """Score localization.

    Raises:
        MissingGroundTruthError: All recordings have gaps or are too short.
    """
    whole = [item for item in source.recordings if is_continuous(item)]
    if not whole:
        raise MissingGroundTruthError("localisation: all recordings have gaps. Collect some with --every 0")
    watch = StageTimer()
    parts = [_followed(recording, watch) for recording in whole]
    estimated, true, covariance, fixes = (np.concatenate(column) for column in zip(*parts, strict=True))
    errors = pose_errors(estimated, true, covariance)
    if errors is None:
        raise MissingGroundTruthError(
            f"localisation: no recording is longer than {SETTLE_S:.0f} s. Collect longer ones"
        )
    fix_rms_m = rms(np.hypot(*(fixes - true[:, :2]).T))
    data = {"drives": len(whole), "errors": errors, "fix_rms_m": fix_rms_m}
    return ScoringResult(plain(data), _page(len(whole), errors, fix_rms_m), watch.stages_ms)


def _followed(recording: Recording, watch: StageTimer) -> tuple[Any, Any, Any, Any]:
    """Return estimates (n, 4), truth (n, 4), position covariances (n, 2, 2) and fixes (n, 2) after `SETTLE_S`."""
    from stucksolver_perception.localization import EkfLocalizer

    localizer = EkfLocalizer(recording.rig)
    rows: list[tuple[Any, Any, Any, Any]] = []
    began_s: float | None = None
    for tick in recording:
        began_s = tick.time_s if began_s is None else began_s
        with watch("localisation"):
            _feed(localizer, tick)
            pose = localizer.estimate(tick.time_s)
        if tick.time_s - began_s >= SETTLE_S:
            found = (pose.x_m, pose.y_m, pose.yaw_rad, pose.speed_mps)
            rows.append((found, tick.pose[[0, 1, 3, 6]], pose.covariance[:2, :2], tick.gnss[:2]))
    columns: list[Any] = list(zip(*rows, strict=True)) if rows else [(), (), (), ()]
    shapes = ((-1, 4), (-1, 4), (-1, 2, 2), (-1, 2))
    estimated, true, covariance, fixes = (
        np.array(column, np.float64).reshape(shape) for column, shape in zip(columns, shapes, strict=True)
    )
    return estimated, true, covariance, fixes


def _feed(localizer: Any, tick: Recorded) -> None:
    a, w = tick.imu[:3].tolist(), tick.imu[3:6].tolist()
    localizer.imu(ImuSample(tick.time_s, (a[0], a[1], a[2]), (w[0], w[1], w[2]), float(tick.imu[6])))
    localizer.wheel(WheelSpeed(tick.time_s, tick.wheel_mps))
    localizer.gnss(GnssFix(tick.time_s, *tick.gnss.tolist()))


def _page(drives: int, errors: PoseErrors, fix_rms_m: float) -> str:
    rows = [
        ("position, RMS", f"{figure(errors.position_rms_m, 2)} m"),
        ("position, 95 %", f"{figure(errors.position_p95_m, 2)} m"),
        ("position, worst", f"{figure(errors.position_worst_m, 2)} m"),
        ("across the heading, RMS", f"{figure(errors.lateral_rms_m, 2)} m"),
        ("heading, RMS", f"{figure(float(np.degrees(errors.yaw_rms_rad)), 2)}°"),
        ("speed, RMS", f"{figure(errors.speed_rms_mps, 3)} m/s"),
        ("within its own 95 % ellipse", percent(errors.within_95)),
        ("a fix alone, RMS", f"{figure(fix_rms_m, 2)} m"),
    ]
    return f"{drives} drives, {errors.moments} moments.\n\n{table(('', ''), rows)}\n"
