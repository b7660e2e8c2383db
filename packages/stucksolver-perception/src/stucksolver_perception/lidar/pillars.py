"""Converts points to pillars (Lang et al. 2019, PointPillars): the network's features of each point, and its pillar.

The network itself holds the learned part: two small layers for each point, and the maximum over the points of a pillar.
`lab.perception.training.lidar.pillars` computes the same with torch; a test compares the two.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.lidar.grid import EGO_HALF_LENGTH_M, EGO_HALF_WIDTH_M, GRID, BevGrid
from stucksolver_perception.measurements import Singles

FEATURES = 8
"""Per point: x and y from the center of its pillar, height, intensity, age, x, y, distance; all about -1 to 1."""
FAR_M = 64.0
TALL_M = 2.0
OLD_S = 0.5


def pillars(points: Singles, grid: BevGrid = GRID) -> tuple[Singles, NDArray[np.int64]]:
    """Return the network's input.

    Args:
        points: (n, 5) float32: x, y, z (m, vehicle frame), intensity (0 to 1), age (s).
        grid: Points beyond it, and on our own body, are left out.

    Returns:
        Features (m, 8) and the pillar of each point (m,), m <= n.
    """
    x, y, z = points[:, 0], points[:, 1], points[:, 2]
    column_x = np.floor((x - np.float32(grid.x_min_m)) / np.float32(grid.pillar_m))
    column_y = np.floor((y - np.float32(grid.y_min_m)) / np.float32(grid.pillar_m))
    kept = (column_x >= 0) & (column_x < 2 * grid.rows) & (column_y >= 0) & (column_y < 2 * grid.columns)
    kept &= (z >= grid.z_min_m) & (z < grid.z_max_m)
    kept &= (np.abs(x) > EGO_HALF_LENGTH_M) | (np.abs(y) > EGO_HALF_WIDTH_M)
    where = np.flatnonzero(kept)
    points, column_x, column_y = points[where], column_x[where], column_y[where]
    x, y, pillar_m = points[:, 0], points[:, 1], np.float32(grid.pillar_m)
    features = np.empty((len(points), FEATURES), np.float32)
    features[:, 0] = (x - (column_x + np.float32(0.5)) * pillar_m - np.float32(grid.x_min_m)) / (pillar_m / 2)
    features[:, 1] = (y - (column_y + np.float32(0.5)) * pillar_m - np.float32(grid.y_min_m)) / (pillar_m / 2)
    features[:, 2] = points[:, 2] / np.float32(TALL_M)
    features[:, 3] = points[:, 3]
    features[:, 4] = points[:, 4] / np.float32(OLD_S)
    features[:, 5] = x / np.float32(FAR_M)
    features[:, 6] = y / np.float32(FAR_M)
    features[:, 7] = np.sqrt(x * x + y * y) / np.float32(FAR_M)
    ix, iy = column_x.astype(np.int64), column_y.astype(np.int64)
    cell = 4 * ((ix >> 1) * grid.columns + (iy >> 1)) + 2 * (ix & 1) + (iy & 1)
    return features, cell


def occupied(cell: NDArray[np.int64], grid: BevGrid = GRID) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Leave out the coarse cells without points, which are most.

    Args:
        cell: (m,) pillars of points.
        grid: Their grid.

    Returns:
        For each point its pillar among those of the occupied cells (m,), and these cells (k,) in order.
    """
    coarse = cell >> 2
    hit = np.zeros(grid.cells, bool)
    hit[coarse] = True
    number = np.cumsum(hit) - 1
    return 4 * number[coarse] + (cell & 3), np.flatnonzero(hit)
