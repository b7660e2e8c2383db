"""Scores of a detector by label and range: average precision at four distances, and errors of true positives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lab.perception.evaluation.metrics.average_precision import average_precision
from lab.perception.evaluation.metrics.box_errors import BoxErrors, box_errors
from lab.perception.evaluation.metrics.matching import Matches, TruthObjects, match
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections

DISTANCES_M = (0.5, 1.0, 2.0, 4.0)
"""Distances of a match at which the average precision is computed, as in nuScenes (m)."""
ERRORS_WITHIN_M = 2.0
"""Distance of a match for the errors, as in nuScenes (m)."""
RINGS_M = ((0.0, 20.0), (20.0, 40.0), (40.0, 60.0), (60.0, 80.0))
"""Ranges of distances from the ego (m)."""
FARTHEST_M = 80.0
"""Distance beyond which nothing counts (m)."""
SURE = 0.5
"""Score from which detections count for precision and recall. Ours."""
_TURNS_ALIKE = ("barrier", "cone", "debris")
"""Labels without a front."""


@dataclass(frozen=True)
class LabelScores:
    """Scores of one label in one range of distances."""

    objects: int
    found: int
    """Number of detections of any score."""
    average_precision: float | None
    """Mean over `DISTANCES_M`; None without objects."""
    at_distances: tuple[float | None, ...]
    precision: float | None
    """Precision of detections with a score of at least `SURE`, matched within 2 m."""
    recall: float | None
    errors: BoxErrors


@dataclass(frozen=True)
class DetectionScores:
    """All scores; the keys of `by_ring` are (nearest, farthest) in meters."""

    samples: int
    mean_average_precision: float | None
    """Mean over the labels that have objects."""
    by_label: Mapping[str, LabelScores]
    by_ring: Mapping[tuple[float, float], Mapping[str, LabelScores]]


def detection_scores(found: Sequence[Detections], reals: Sequence[TruthObjects]) -> DetectionScores:
    """Score detections against objects of the same samples; nothing counts beyond `FARTHEST_M`."""
    by_label: dict[str, LabelScores] = {}
    by_ring: dict[tuple[float, float], dict[str, LabelScores]] = {ring: {} for ring in RINGS_M}
    for label, name in enumerate(LABELS):
        matches = {within: match(found, reals, label, within) for within in DISTANCES_M}
        alike = name in _TURNS_ALIKE
        by_label[name] = _scores(matches, (0.0, FARTHEST_M), found, reals, alike)
        for ring in RINGS_M:
            by_ring[ring][name] = _scores(matches, ring, found, reals, alike)
    return DetectionScores(len(found), mean_of(by_label), by_label, by_ring)


def mean_of(scores: Mapping[str, LabelScores]) -> float | None:
    """Return the mean average precision over labels that have objects; None if there are none."""
    known = [score.average_precision for score in scores.values() if score.average_precision is not None]
    return float(np.mean(known)) if known else None


def _scores(
    matches: Mapping[float, Matches],
    ring: tuple[float, float],
    found: Sequence[Detections],
    reals: Sequence[TruthObjects],
    turns_alike: bool,
) -> LabelScores:
    inside = {within: item.between(*ring) for within, item in matches.items()}
    chosen = inside[ERRORS_WITHIN_M]
    objects = len(chosen.real_range_m)
    each = tuple(average_precision(item.right, objects) for item in inside.values())
    known = [value for value in each if value is not None]
    sure = chosen.right[chosen.score >= SURE]
    return LabelScores(
        objects=objects,
        found=len(chosen.right),
        average_precision=float(np.mean(known)) if known else None,
        at_distances=each,
        precision=float(sure.mean()) if len(sure) else None,
        recall=float(sure.sum()) / objects if objects else None,
        errors=box_errors(chosen, found, reals, turns_alike) if objects else BoxErrors(None, None, None, None),
    )
