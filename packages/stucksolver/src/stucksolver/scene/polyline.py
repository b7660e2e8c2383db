"""Polylines as arrays of points: arc lengths, and the points nearest to a position."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def arc_lengths(points: Array) -> Array:
    """Return the distance along the line from the first of `points` (n, 2) to each of them (m), shape (n,)."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])


def distances(points: Array, x: float, y: float) -> Array:
    """Return the distance in the plane from (x, y) to each of `points` (n, 2 or more) (m), shape (n,)."""
    result: Array = np.hypot(points[:, 0] - x, points[:, 1] - y)
    return result


def nearest_index(points: Array, x: float, y: float) -> int:
    """Return the index of the point nearest to (x, y) in the plane; the first of several equally near ones."""
    return int(np.argmin((points[:, 0] - x) ** 2 + (points[:, 1] - y) ** 2))


def nearest_of_each_pass(near: Mask, away: Array) -> Iterator[int]:
    """Yield, for each run of points that are `near`, the index of the one with the smallest `away`."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], near, [False]]).astype(np.int8)))
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        yield int(first + np.argmin(away[first:last]))
