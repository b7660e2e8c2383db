"""Scores the LiDAR detector at the time of each image."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lab.perception.evaluation.metrics.detection import DetectionScores, LabelScores, detection_scores, mean_of
from lab.perception.evaluation.metrics.matching import TruthObjects
from lab.perception.evaluation.metrics.pedestrian_recall import MARGIN_M, NEAR_M, PedestrianRecall, coverage
from lab.perception.evaluation.scoring.samples import TURN_S, reals_of, true_pose
from lab.perception.evaluation.scoring.scoring_part import (
    ScoringInput,
    ScoringResult,
    StageTimer,
    figure,
    percent,
    plain,
    table,
)
from stucksolver_perception.measurements import Detections

NOTHING = np.zeros((0, 8))
"""Rows of tracked vehicles: none are tracked here."""


def score_lidar(source: ScoringInput) -> ScoringResult:
    """Score detection on sweeps that are joined with true poses.

    Raises:
        NetworkFileError: A network cannot be used.
    """
    from stucksolver_perception.lidar.detector import LidarDetector
    from stucksolver_perception.lidar.refinement.unexplained_returns import standing_returns, with_unexplained
    from stucksolver_perception.lidar.sweeps import SweepBuffer

    options = {} if source.lidar_weights is None else {"folder": source.lidar_weights}
    detector, watch = LidarDetector(**options), StageTimer()
    found: list[Detections] = []
    reals: list[TruthObjects] = []
    alone, joined = PedestrianRecall(), PedestrianRecall()
    for recording in source.recordings:
        buffer = SweepBuffer()
        for tick in recording:
            pose = true_pose(tick)
            buffer.add(tick.sweep, pose)
            if tick.jpeg is None:
                continue
            with watch("sweeps"):
                points = buffer.gather(pose)
            with watch("lidar"):
                found.append(detector.detect(points, tick.time_s))
            reals.append(reals_of(tick, points))
            turn = points[points[:, 4] <= TURN_S]
            every = with_unexplained(found[-1], standing_returns(turn, recording.rig.lidar), NOTHING)
            alone, joined = alone + coverage(found[-1], reals[-1]), joined + coverage(every, reals[-1])
        source.say(f"lidar: {recording.folder.name}")
    scores = detection_scores(found, reals)
    data = plain(scores) | {"people": plain(alone), "people_with_unnamed": plain(joined)}
    return ScoringResult(data, _page(scores) + _people(alone, joined), watch.stages_ms)


def _page(scores: DetectionScores) -> str:
    rows = [_row(name, item) for name, item in scores.by_label.items()]
    of_errors = ("ATE m", "ASE", "AOE rad", "AVE m/s")
    head = ("class", "objects", "AP", "at 0.5 m", "1 m", "2 m", "4 m", "recall", "precision", *of_errors)
    rings = [_ring(ring, mapping) for ring, mapping in scores.by_ring.items()]
    names = tuple(scores.by_label)
    return (
        f"{scores.samples} samples; mAP {figure(scores.mean_average_precision)}. Recall and precision are those of "
        f"detections with a score of at least 0.5, matched within 2 m.\n\n{table(head, rows)}\n\n"
        f"AP by range:\n\n{table(('range', 'mAP', *names), rings)}\n"
    )


def _people(alone: PedestrianRecall, joined: PedestrianRecall) -> str:
    near = (_share(recall.covered, recall.people) for recall in (alone, joined))
    ahead = (_share(recall.ahead_covered, recall.ahead) for recall in (alone, joined))
    rows = [(f"within {NEAR_M:.0f} m ({alone.people})", *near), (f"close ahead ({alone.ahead})", *ahead)]
    head = ("people", "by the network", "with unnamed obstacles")
    return f"\nPeople in a box of any class, enlarged by {MARGIN_M} m:\n\n{table(head, rows)}\n"


def _share(part: int, whole: int) -> str:
    return percent(part / whole if whole else None)


def _row(name: str, scores: LabelScores) -> tuple[str, ...]:
    errors = scores.errors
    off = (errors.translation_m, errors.scale, errors.orientation_rad, errors.velocity_mps)
    return (
        name,
        str(scores.objects),
        figure(scores.average_precision),
        *(figure(each) for each in scores.at_distances),
        percent(scores.recall),
        percent(scores.precision),
        *(figure(each, 2) for each in off),
    )


def _ring(ring: tuple[float, float], by_label: Mapping[str, LabelScores]) -> tuple[str, ...]:
    each = tuple(f"{figure(item.average_precision)} ({item.objects})" for item in by_label.values())
    return (f"{ring[0]:.0f} to {ring[1]:.0f} m", figure(mean_of(by_label)), *each)
