"""Clusters returns, and adds stationary objects to the detections."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import Detections, Floats


def clusters_of(cells: NDArray[np.int64]) -> list[NDArray[np.bool_]]:
    """Return a mask (m,) of the returns for each cluster of cells that touch, including at corners.

    Args:
        cells: (m, 2): the cell of each return, without negative numbers.
    """
    from scipy import ndimage  # type: ignore[import-untyped]

    occupied = np.zeros(cells.max(axis=0) + 1, np.bool_)
    occupied[cells[:, 0], cells[:, 1]] = True
    clusters, count = ndimage.label(occupied, np.ones((3, 3)))
    cluster = clusters[cells[:, 0], cells[:, 1]]
    return [cluster == n for n in range(1, count + 1)]


def with_stationary(
    detections: Detections, label: NDArray[np.int64], score: float, center: Floats, size: Floats
) -> Detections:
    """Return the detections, followed by n stationary objects along the vehicle's axes.

    Args:
        detections: Detections in the vehicle frame.
        label: (n,): index into `LABELS`.
        score: Score of each object.
        center: (n, 3): centers (m).
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
