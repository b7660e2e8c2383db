"""Clusters of returns that the detector did not name, and how they are added to what it did."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import Detections, Floats


def clusters_of(cells: NDArray[np.int64]) -> list[NDArray[np.bool_]]:
    """Return which of the returns belong together, for each cluster of cells that touch, corners included.

    Args:
        cells: (m, 2): the cell of each return, none of them negative.
    """
    from scipy import ndimage  # type: ignore[import-untyped]

    taken = np.zeros(cells.max(axis=0) + 1, np.bool_)
    taken[cells[:, 0], cells[:, 1]] = True
    clusters, count = ndimage.label(taken, np.ones((3, 3)))
    cluster = clusters[cells[:, 0], cells[:, 1]]
    return [cluster == n for n in range(1, count + 1)]


def with_standing(
    detections: Detections, label: NDArray[np.int64], score: float, center: Floats, size: Floats
) -> Detections:
    """Return the detections, and after them n that stand, along the vehicle's axes.

    Args:
        detections: In the vehicle frame.
        label: (n,): index into `LABELS`.
        score: Of each.
        center: (n, 3) (m).
        size: (n, 3): length, width, height (m).
    """
    n = len(label)
    return Detections(
        detections.time_s,
        np.concatenate([detections.label, label]),
        np.concatenate([detections.score, np.full(n, score)]),
        np.concatenate([detections.center, center]),
        np.concatenate([detections.size, size]),
        np.concatenate([detections.yaw, np.zeros(n)]),
        np.concatenate([detections.velocity, np.zeros((n, 2))]),
    )
