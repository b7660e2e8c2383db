"""Measures the LiDAR detector's noise on recordings without gaps: the numbers that the tracker assumes."""

from __future__ import annotations

from collections.abc import Mapping

from lab.perception.evaluation.metrics.detector_noise import LabelNoise, detector_noise
from lab.perception.evaluation.metrics.matching import TruthObjects
from lab.perception.evaluation.scoring.samples import is_continuous, looks_of, reals_of, true_pose
from lab.perception.evaluation.scoring.scoring_part import (
    MissingGroundTruthError,
    ScoringInput,
    ScoringResult,
    figure,
    percent,
    plain,
    table,
)
from stucksolver_perception.measurements import Detections
from stucksolver_perception.recording import Recording


def score_noise(source: ScoringInput) -> ScoringResult:
    """Measure the noise.

    Raises:
        NetworkFileError: A network cannot be used.
        MissingGroundTruthError: All recordings have gaps.
    """
    whole = [item for item in source.recordings if is_continuous(item)]
    if not whole:
        raise MissingGroundTruthError("noise: all recordings have gaps. Collect some with --every 0")
    drives = []
    for recording in whole:
        drives.append(_looks(source, recording))
        source.say(f"noise: {recording.folder.name}")
    noise = detector_noise(drives)
    return ScoringResult(plain({"drives": len(whole), "by_ring": noise}), _page(len(whole), noise))


def _looks(source: ScoringInput, recording: Recording) -> tuple[list[Detections], list[TruthObjects]]:
    from stucksolver_perception.lidar.detector import LidarDetector
    from stucksolver_perception.lidar.sweeps import SweepBuffer

    options = {} if source.lidar_weights is None else {"folder": source.lidar_weights}
    detector, buffer = LidarDetector(**options), SweepBuffer()
    found: list[Detections] = []
    reals: list[TruthObjects] = []
    for ticks in looks_of(recording):
        for each in ticks:
            buffer.add(each.sweep, true_pose(each))
        tick = ticks[-1]
        points = buffer.gather(true_pose(tick))
        found.append(detector.detect(points, tick.time_s))
        reals.append(reals_of(tick, points))
    return found, reals


def _page(drives: int, noise: Mapping[tuple[float, float], Mapping[str, LabelNoise]]) -> str:
    of_places = ("objects", "recall", "false per look", "confident false per look", "jitter m", "drift in 1 s m")
    head = ("class", *of_places, "yaw rad", "flipped", "velocity m/s, standing", "moving")
    pieces = [
        f"{drives} drives. Pairs are along and across the object's axis; 68 % of the errors are below the figures. "
        "Jitter is the noise between consecutive looks; drift is the change of an error within a second.\n"
    ]
    for ring, by_label in noise.items():
        rows = [_row(name, item) for name, item in by_label.items() if item.objects]
        pieces.append(f"{ring[0]:.0f} to {ring[1]:.0f} m:\n\n{table(head, rows)}\n")
    return "\n".join(pieces)


def _row(name: str, noise: LabelNoise) -> tuple[str, ...]:
    return (
        name,
        str(noise.objects),
        percent(noise.recall),
        figure(noise.false_per_look, 2),
        figure(noise.sure_false_per_look, 2),
        _pair(noise.jitter_m),
        _pair(noise.drift_m),
        figure(noise.yaw_rad, 2),
        percent(noise.flipped),
        _pair(noise.standing_mps),
        _pair(noise.moving_mps),
    )


def _pair(values: tuple[float | None, float | None]) -> str:
    return f"{figure(values[0], 2)} / {figure(values[1], 2)}"
