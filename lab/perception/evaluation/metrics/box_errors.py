"""Errors of true positives in position, size, heading and velocity (nuScenes' ATE, ASE, AOE, AVE).

Caesar et al., "nuScenes: A multimodal dataset for autonomous driving", CVPR 2020, section 3.3. As there, each error is
averaged over the recall levels that are reached, from 10 % on, so that confident boxes weigh no more than others.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lab.perception.evaluation.metrics.average_precision import LEAST_RECALL, LEVELS
from lab.perception.evaluation.metrics.matching import Matches, TruthObjects
from stucksolver_perception.measurements import Detections, Floats


@dataclass(frozen=True)
class BoxErrors:
    """Mean errors; None if too few objects are found."""

    translation_m: float | None
    scale: float | None
    """1 - intersection over union of the boxes after aligning position and heading."""
    orientation_rad: float | None
    velocity_mps: float | None


def box_errors(
    matches: Matches, found: Sequence[Detections], reals: Sequence[TruthObjects], turns_alike: bool = False
) -> BoxErrors:
    """Return the errors of the true positives among `matches`.

    Args:
        matches: Matches of one label.
        found: Detections of each sample, in the vehicle frame.
        reals: Objects of the same samples.
        turns_alike: True if the label looks the same from the front and from behind.
    """
    hits = np.flatnonzero(matches.right)
    wanted = len(matches.real_range_m)
    rows = [errors_of(found, reals, matches, k, turns_alike) for k in hits.tolist()]
    if not rows or len(hits) / wanted <= LEAST_RECALL:
        return BoxErrors(None, None, None, None)
    columns = np.array(rows).T
    recall = np.arange(1, len(hits) + 1) / wanted
    return BoxErrors(*(_over_recall(column, recall) for column in columns))


def errors_of(
    found: Sequence[Detections], reals: Sequence[TruthObjects], matches: Matches, k: int, turns_alike: bool
) -> tuple[float, float, float, float]:
    """Return the errors of the true positive in row `k`, in the order of `BoxErrors`."""
    detected, true = found[matches.sample[k]], reals[matches.sample[k]]
    i, j = int(matches.detection[k]), int(matches.real[k])
    return (
        float(np.hypot(*(detected.center[i, :2] - true.center[j, :2]))),
        1.0 - size_overlap(detected.size[i], true.size[j]),
        turn_between(float(detected.yaw[i]), float(true.yaw[j]), math.pi if turns_alike else math.tau),
        float(np.hypot(*(detected.velocity[i] - true.velocity[j]))),
    )


def size_overlap(first: Floats, second: Floats) -> float:
    """Return the intersection over union of two box sizes, shape (3,), at the same position and heading."""
    common = float(np.prod(np.minimum(first, second)))
    return common / (float(np.prod(first)) + float(np.prod(second)) - common)


def turn_between(first: float, second: float, period: float = math.tau) -> float:
    """Return the smallest angle between two headings (rad), modulo `period` (rad)."""
    return abs(math.remainder(first - second, period))


def _over_recall(errors: Floats, recall: Floats) -> float:
    """Return the mean, over recall levels, of the mean error up to each level."""
    running = np.cumsum(errors) / np.arange(1, len(errors) + 1)
    levels = np.linspace(0.0, 1.0, LEVELS)
    levels = levels[(levels > LEAST_RECALL + 1e-9) & (levels <= recall[-1] + 1e-9)]
    if not len(levels):
        return float(running[-1])
    return float(np.interp(levels, recall, running).mean())
