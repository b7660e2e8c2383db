"""The pillars of `stucksolver_perception.lidar.pillars` in torch, for a batch of windows."""

from __future__ import annotations

import torch
from torch import Tensor

from stucksolver_perception.lidar.grid import EGO_HALF_LENGTH_M, EGO_HALF_WIDTH_M, GRID, BevGrid
from stucksolver_perception.lidar.pillars import AGE_UNIT_S, DISTANCE_UNIT_M, HEIGHT_UNIT_M


def pillars(points: Tensor, window: Tensor, grid: BevGrid = GRID) -> tuple[Tensor, Tensor]:
    """Return features (m, 8) and pillar indices (m,) of points (n, 5) in several windows.

    Pillar indices of window w start at w * `grid.pillars`.
    """
    x, y, z = points[:, 0], points[:, 1], points[:, 2]
    side = torch.tensor(grid.pillar_m, dtype=points.dtype, device=points.device)
    column_x, column_y = torch.floor((x - grid.x_min_m) / side), torch.floor((y - grid.y_min_m) / side)
    is_kept = (column_x >= 0) & (column_x < 2 * grid.rows) & (column_y >= 0) & (column_y < 2 * grid.columns)
    is_kept &= (z >= grid.z_min_m) & (z < grid.z_max_m)
    is_kept &= (x.abs() > EGO_HALF_LENGTH_M) | (y.abs() > EGO_HALF_WIDTH_M)
    points, window, column_x, column_y = points[is_kept], window[is_kept], column_x[is_kept], column_y[is_kept]
    x, y = points[:, 0], points[:, 1]
    features = torch.stack(
        [
            (x - (column_x + 0.5) * side - grid.x_min_m) / (side / 2),
            (y - (column_y + 0.5) * side - grid.y_min_m) / (side / 2),
            points[:, 2] / HEIGHT_UNIT_M,
            points[:, 3],
            points[:, 4] / AGE_UNIT_S,
            x / DISTANCE_UNIT_M,
            y / DISTANCE_UNIT_M,
            torch.sqrt(x * x + y * y) / DISTANCE_UNIT_M,
        ],
        dim=1,
    )
    ix, iy = column_x.long(), column_y.long()
    cell = 4 * ((ix >> 1) * grid.columns + (iy >> 1)) + 2 * (ix & 1) + (iy & 1)
    return features, cell + window * grid.pillars
