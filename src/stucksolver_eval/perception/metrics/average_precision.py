"""Average precision as nuScenes has it: the area below precision over recall, without what is below a tenth of either.

Caesar et al., "nuScenes: A multimodal dataset for autonomous driving", CVPR 2020, section 3.3.
"""

from __future__ import annotations

import numpy as np

from stucksolver.perception.measurements import Floats
from stucksolver_eval.perception.metrics.matching import Flags

LEAST_RECALL, LEAST_PRECISION = 0.1, 0.1
LEVELS = 101
"""Of recall, from 0 to 1, between which the curve is straight."""


def average_precision(right: Flags, wanted: int) -> float | None:
    """Of detections in the order of falling score.

    Args:
        right: (n,): Is each of them one of the objects?
        wanted: How many objects there are.

    Returns:
        0 to 1; None where there is no object, so that nothing can be said.
    """
    if wanted == 0:
        return None
    levels = np.linspace(0.0, 1.0, LEVELS)
    precision = np.interp(levels, *curve(right, wanted), right=0.0)
    above = np.maximum(precision[levels > LEAST_RECALL + 1e-9] - LEAST_PRECISION, 0.0)
    return float(above.mean() / (1.0 - LEAST_PRECISION))


def curve(right: Flags, wanted: int) -> tuple[Floats, Floats]:
    """Recall and precision after each detection, both (n,); `([0], [0])` where there are none."""
    if not len(right):
        return np.zeros(1), np.zeros(1)
    hits = np.cumsum(right)
    return hits / wanted, hits / np.arange(1, len(right) + 1)
