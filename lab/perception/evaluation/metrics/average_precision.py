"""Average precision of nuScenes: the normalized area under the precision-recall curve above 10 % recall and precision.

Caesar et al., "nuScenes: A multimodal dataset for autonomous driving", CVPR 2020, section 3.3.
"""

from __future__ import annotations

import numpy as np

from lab.perception.evaluation.metrics.matching import Flags
from stucksolver_perception.measurements import Floats

LEAST_RECALL, LEAST_PRECISION = 0.1, 0.1
"""Recall and precision above which the area counts, as in nuScenes."""
LEVELS = 101
"""Number of recall levels from 0 to 1; the curve is interpolated linearly between them."""


def average_precision(right: Flags, wanted: int) -> float | None:
    """Return the average precision of detections in order of decreasing score.

    Args:
        right: Shape (n,): True for true positives.
        wanted: Number of objects.

    Returns:
        0 to 1; None if there are no objects.
    """
    if wanted == 0:
        return None
    levels = np.linspace(0.0, 1.0, LEVELS)
    precision = np.interp(levels, *curve(right, wanted), right=0.0)
    above = np.maximum(precision[levels > LEAST_RECALL + 1e-9] - LEAST_PRECISION, 0.0)
    return float(above.mean() / (1.0 - LEAST_PRECISION))


def curve(right: Flags, wanted: int) -> tuple[Floats, Floats]:
    """Return recall and precision after each detection, both of shape (n,); `([0], [0])` without detections."""
    if not len(right):
        return np.zeros(1), np.zeros(1)
    hits = np.cumsum(right)
    return hits / wanted, hits / np.arange(1, len(right) + 1)
