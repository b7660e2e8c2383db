"""Finds single returns from spray, rain and snow, which the network would detect as objects.

A return from an object has neighbors; one from a drop has none. This is the idea of radius outlier filters for snow
(e.g. Charron et al. 2018, "De-noising of LiDAR point clouds corrupted by snowfall"), with cells instead of radii. Far
objects have single returns too, so that no return is dropped in clear air.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import Singles

BOTTOM_M = 0.25
"""Minimum height of an isolated return (m). Lower ones may be the road, where neighboring rings are meters apart."""
TOP_M = 4.0
"""Maximum height of an isolated return (m). Ours."""
NEAR_M, REACH_M = 8.0, 30.0
"""Distances up to which neighbors are searched in cells of the first and the second size of `CELLS_M` (m). Ours."""
CELLS_M = (0.25, 0.5)
"""Sides of the near and the far cells (m). Ours."""
MAX_RETURNS = 2
"""Maximum number of returns in the cell of an isolated return and the 26 cells around it, including itself. Ours."""
SPRAY, THICK = 0.005, 0.015
"""Shares of isolated returns above which there is spray, and above which the sweep is dropped. The rest of thicker
spray looks like pedestrians, and the vehicle would brake for them in the middle of a turn. In clear air the share was
at most
0.002 in our recordings, which have no spray."""


def isolated_points(points: Singles) -> NDArray[np.bool_]:
    """Return (n,): True for isolated points (n, 4) of a sweep in the vehicle frame; never for far, low and high
    ones.
    """
    is_isolated = np.zeros(len(points), bool)
    distance = np.maximum(np.abs(points[:, 0]), np.abs(points[:, 1]))
    tall = (points[:, 2] > BOTTOM_M) & (points[:, 2] < TOP_M) & (distance < REACH_M)
    for cell_m, inner_m, outer_m in zip(CELLS_M, (0.0, NEAR_M), (NEAR_M, REACH_M), strict=True):
        # The grid is larger than the ring, so that the ring's points have all their neighbors.
        reach_m = outer_m + 2 * cell_m
        rows = np.flatnonzero(tall & (distance < reach_m))
        # One more empty cell on each side keeps all neighbors of a cell within the grid.
        side, floors = int(2 * reach_m / cell_m) + 3, int(TOP_M / cell_m) + 3
        x, y = (((points[rows, i] + reach_m) / cell_m).astype(np.int64) + 1 for i in (0, 1))
        cell = (x * side + y) * floors + (points[rows, 2] / cell_m).astype(np.int64) + 1
        counts = np.bincount(cell, minlength=side * side * floors)
        inside = (distance[rows] >= inner_m) & (distance[rows] < outer_m)
        candidates = np.flatnonzero(inside & (counts[cell] <= MAX_RETURNS))
        neighbors = (
            (np.arange(-1, 2)[:, None] * side + np.arange(-1, 2)).reshape(-1, 1) * floors + np.arange(-1, 2)
        ).ravel()
        num_near = counts[cell[candidates, None] + neighbors].sum(axis=1)
        is_isolated[rows[candidates[num_near <= MAX_RETURNS]]] = True
    return is_isolated
