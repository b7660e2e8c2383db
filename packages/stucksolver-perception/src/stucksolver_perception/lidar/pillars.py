"""Converts points to pillars (Lang et al. 2019, PointPillars): the network's features of each point, and its pillar.

The network contains the learned part: two small layers for each point, and the maximum over the points of a pillar.
`lab.perception.training.lidar.pillars` computes the same with torch; a test compares the two.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.lidar.grid import EGO_HALF_LENGTH_M, EGO_HALF_WIDTH_M, GRID, BevGrid
from stucksolver_perception.measurements import Singles

FEATURES = 8
"""Number of features of a point: x and y from the center of its pillar, height, intensity, age, x, y, distance; all
about -1 to 1."""
DISTANCE_UNIT_M = 64.0
"""Unit of positions and distances in the features (m), as in training."""
HEIGHT_UNIT_M = 2.0
"""Unit of heights in the features (m), as in training."""
AGE_UNIT_S = 0.5
"""Unit of ages in the features (s), as in training."""


def pillars(points: Singles, grid: BevGrid = GRID) -> tuple[Singles, NDArray[np.int64]]:
    """Return the network's input.

    Args:
        points: (n, 5) float32: x, y, z (m, vehicle frame), intensity (0 to 1), age (s).
        grid: The grid. Points outside it, and on the ego, are left out.

    Returns:
        Features (m, 8), and the pillar of each point (m,); m <= n.
    """
    x, y, z = points[:, 0], points[:, 1], points[:, 2]
    column_x = np.floor((x - np.float32(grid.x_min_m)) / np.float32(grid.pillar_m))
    column_y = np.floor((y - np.float32(grid.y_min_m)) / np.float32(grid.pillar_m))
    in_grid = (column_x >= 0) & (column_x < 2 * grid.rows) & (column_y >= 0) & (column_y < 2 * grid.columns)
    in_grid &= (z >= grid.z_min_m) & (z < grid.z_max_m)
    in_grid &= (np.abs(x) > EGO_HALF_LENGTH_M) | (np.abs(y) > EGO_HALF_WIDTH_M)
    rows = np.flatnonzero(in_grid)
    points, column_x, column_y = points[rows], column_x[rows], column_y[rows]
    x, y, pillar_m = points[:, 0], points[:, 1], np.float32(grid.pillar_m)
    features = np.empty((len(points), FEATURES), np.float32)
    features[:, 0] = (x - (column_x + np.float32(0.5)) * pillar_m - np.float32(grid.x_min_m)) / (pillar_m / 2)
    features[:, 1] = (y - (column_y + np.float32(0.5)) * pillar_m - np.float32(grid.y_min_m)) / (pillar_m / 2)
    features[:, 2] = points[:, 2] / np.float32(HEIGHT_UNIT_M)
    features[:, 3] = points[:, 3]
    features[:, 4] = points[:, 4] / np.float32(AGE_UNIT_S)
    features[:, 5] = x / np.float32(DISTANCE_UNIT_M)
    features[:, 6] = y / np.float32(DISTANCE_UNIT_M)
    features[:, 7] = np.sqrt(x * x + y * y) / np.float32(DISTANCE_UNIT_M)
    ix, iy = column_x.astype(np.int64), column_y.astype(np.int64)
    cell = 4 * ((ix >> 1) * grid.columns + (iy >> 1)) + 2 * (ix & 1) + (iy & 1)
    return features, cell


def occupied(cell: NDArray[np.int64], grid: BevGrid = GRID) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the pillars without the coarse cells that have no points, which are most.

    Args:
        cell: (m,): pillars of points.
        grid: Their grid.

    Returns:
        For each point its pillar among those of the occupied cells (m,), and these cells in order (k,).
    """
    coarse = cell >> 2
    has_points = np.zeros(grid.cells, bool)
    has_points[coarse] = True
    number = np.cumsum(has_points) - 1
    return 4 * number[coarse] + (cell & 3), np.flatnonzero(has_points)
