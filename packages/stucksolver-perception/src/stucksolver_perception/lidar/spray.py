"""Spray, rain and snow: single returns from the air, which the network would take for objects.

A return from a body has neighbors, one from a drop has not. This is the idea of the radius outlier filters for snow
(e.g. Charron et al. 2018, "De-noising of LiDAR point clouds corrupted by snowfall"), with cells instead of radii. Far
bodies have single returns too, so that nothing is dropped as long as the air is clear.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import Singles

ABOVE_M = 0.25
"""Lower points may be the road, where neighboring rings are meters apart."""
TOP_M = 4.0
NEAR_M, REACH_M = 8.0, 30.0
"""Up to the first distance neighbors are looked for in cells of the first size of `CELLS_M`, up to the second in those
of the other size.
"""
CELLS_M = (0.25, 0.5)
FEW = 2
"""A return is stray if its cell and the 26 around it contain at most this many, itself included."""
SPRAY, THICK = 0.005, 0.015
"""With more stray returns than the first share of all, there is spray; with more than the second, the sweep is not
believed: what remains of thicker spray looks like people, and the vehicle brakes for them in the midst of a turn. In
clear air the share was at most 0.002 on our recordings, which have no spray.
"""


def isolated_points(points: Singles) -> NDArray[np.bool_]:
    """Return which points (n, 4) of a sweep in the vehicle frame are stray; far, low and very high ones never are."""
    found = np.zeros(len(points), bool)
    away = np.maximum(np.abs(points[:, 0]), np.abs(points[:, 1]))
    tall = (points[:, 2] > ABOVE_M) & (points[:, 2] < TOP_M) & (away < REACH_M)
    for cell_m, inner_m, outer_m in zip(CELLS_M, (0.0, NEAR_M), (NEAR_M, REACH_M), strict=True):
        # The cells reach a little further than the ring, so that its points have all their neighbors.
        reach_m = outer_m + 2 * cell_m
        rows = np.flatnonzero(tall & (away < reach_m))
        # One empty cell more at each side: a cell and its neighbors are then in the grid.
        side, floors = int(2 * reach_m / cell_m) + 3, int(TOP_M / cell_m) + 3
        x, y = (((points[rows, i] + reach_m) / cell_m).astype(np.int64) + 1 for i in (0, 1))
        cell = (x * side + y) * floors + (points[rows, 2] / cell_m).astype(np.int64) + 1
        counts = np.bincount(cell, minlength=side * side * floors)
        inside = (away[rows] >= inner_m) & (away[rows] < outer_m)
        lone = np.flatnonzero(inside & (counts[cell] <= FEW))
        neighbors = (
            (np.arange(-1, 2)[:, None] * side + np.arange(-1, 2)).reshape(-1, 1) * floors + np.arange(-1, 2)
        ).ravel()
        near = counts[cell[lone, None] + neighbors].sum(axis=1)
        found[rows[lone[near <= FEW]]] = True
    return found
