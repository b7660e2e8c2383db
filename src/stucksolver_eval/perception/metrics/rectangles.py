"""Rectangles in a picture: which found one is which wanted one."""

from __future__ import annotations

import numpy as np

from stucksolver.perception.measurements import Floats
from stucksolver_eval.perception.metrics.matching import Flags


def overlaps(one: Floats, other: Floats) -> Floats:
    """(n, m) intersection over union of rectangles (n, 4) and (m, 4): left, top, right, bottom (px)."""
    low = np.maximum(one[:, None, :2], other[None, :, :2])
    high = np.minimum(one[:, None, 2:], other[None, :, 2:])
    common = np.prod(np.maximum(high - low, 0.0), axis=2)
    area, other_area = (np.prod(box[:, 2:] - box[:, :2], axis=1) for box in (one, other))
    together = area[:, None] + other_area[None, :] - common
    return np.asarray(common / np.maximum(together, 1e-9))


def matched(found: Floats, score: Floats, wanted: Floats, least: float) -> tuple[Flags, Flags]:
    """Greedily, the surest first: which of `found` (n, 4) are right, and which of `wanted` (m, 4) are found.

    `least`: the overlap from which on a rectangle is the wanted one. One that overlaps another's object is wrong.
    """
    right, taken = np.zeros(len(found), np.bool_), np.zeros(len(wanted), np.bool_)
    over = overlaps(found, wanted)
    for k in np.argsort(-score, kind="stable").tolist():
        free = np.where(taken, -1.0, over[k])
        if len(free) and free.max() >= least:
            right[k] = taken[int(free.argmax())] = True
    return right, taken
