"""Matches rectangles in an image."""

from __future__ import annotations

import numpy as np

from lab.perception.evaluation.metrics.matching import Flags
from stucksolver_perception.measurements import Floats


def overlaps(first: Floats, second: Floats) -> Floats:
    """Return the intersection over union of rectangles of shapes (n, 4) and (m, 4), as shape (n, m).

    A rectangle is left, top, right, bottom (px).
    """
    low = np.maximum(first[:, None, :2], second[None, :, :2])
    high = np.minimum(first[:, None, 2:], second[None, :, 2:])
    common = np.prod(np.maximum(high - low, 0.0), axis=2)
    area, other_area = (np.prod(box[:, 2:] - box[:, :2], axis=1) for box in (first, second))
    together = area[:, None] + other_area[None, :] - common
    return np.asarray(common / np.maximum(together, 1e-9))


def matched(found: Floats, score: Floats, wanted: Floats, least: float) -> tuple[Flags, Flags]:
    """Match rectangles greedily in decreasing score. A second match of the same rectangle is a false positive.

    Args:
        found: Shape (n, 4): detected rectangles (px).
        score: Shape (n,).
        wanted: Shape (m, 4): true rectangles (px).
        least: Smallest intersection over union of a match.

    Returns:
        True positives among `found`, shape (n,), and those of `wanted` that were found, shape (m,).
    """
    right, taken = np.zeros(len(found), np.bool_), np.zeros(len(wanted), np.bool_)
    over = overlaps(found, wanted)
    for k in np.argsort(-score, kind="stable").tolist():
        free = np.where(taken, -1.0, over[k])
        if len(free) and free.max() >= least:
            right[k] = taken[int(free.argmax())] = True
    return right, taken
