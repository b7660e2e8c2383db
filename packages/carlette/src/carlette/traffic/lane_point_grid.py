"""Finds the lane points under or next to each body, for lead vehicles, crossing traffic and objects on the road."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from carlette.geometry import Floats
from carlette.physics.bodies import BodyTable
from carlette.world.fork import shared

Ints = NDArray[np.int64]

CELL_M = 4.0
"""Size of a cell (m). Ours."""
BESIDE_M = 1.3
"""Distance between a body and the center of a lane below which the lane is blocked (m).

Ours: half a car's width and some clearance.
"""
OTHER_LEVEL_M = 3.0
"""Height difference above which bodies are on another level of the road (m). Ours."""


@shared
@dataclass(frozen=True, eq=False)
class LanePointGrid:
    """Lane points sorted into square cells. It never changes."""

    low: Ints
    """Column and row of the first cell."""
    shape: tuple[int, int]
    first: Ints
    """(cells + 1): start of each cell's points in `points`."""
    points: Ints

    def candidates(self, place: Floats, reach_m: float) -> tuple[Ints, Ints]:
        """Return pairs (row of `place`, lane point) within about `reach_m`."""
        radius = int(np.ceil(reach_m / CELL_M))
        span = np.arange(-radius, radius + 1)
        cell = np.floor(place[:, :2] / CELL_M).astype(np.int64) - self.low
        columns = (cell[:, 0, None] + span)[:, :, None]
        rows = (cell[:, 1, None] + span)[:, None, :]
        valid = (columns >= 0) & (columns < self.shape[0]) & (rows >= 0) & (rows < self.shape[1])
        row, x, y = np.nonzero(valid)
        number = columns[row, x, 0] * self.shape[1] + rows[row, 0, y]
        begin = self.first[number]
        count = self.first[number + 1] - begin
        keep = count > 0
        row, begin, count = row[keep], begin[keep], count[keep]
        offset = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        return np.repeat(row, count), self.points[np.repeat(begin, count) + offset]


def make_grid(place: Floats) -> LanePointGrid:
    """Return the grid of some points."""
    cell = np.floor(place[:, :2] / CELL_M).astype(np.int64)
    low = cell.min(axis=0)
    shape = cell.max(axis=0) - low + 1
    number = (cell[:, 0] - low[0]) * shape[1] + cell[:, 1] - low[1]
    order = np.argsort(number, kind="stable")
    first = np.searchsorted(number[order], np.arange(int(shape[0] * shape[1]) + 1))
    return LanePointGrid(low, (int(shape[0]), int(shape[1])), first, order)


def blocked_points(grid: LanePointGrid, place: Floats, bodies: BodyTable) -> tuple[Ints, Ints]:
    """Return pairs (row of `BodyTable`, lane point) for all solid bodies that block a car at that point."""
    rows = np.flatnonzero(bodies.solid)
    yaw = np.radians(bodies.rotation[rows, 1])
    cos, sin = np.cos(yaw), np.sin(yaw)
    offset, half = bodies.center[rows], bodies.extent[rows]
    middle = bodies.position[rows]
    middle[:, 0] += offset[:, 0] * cos - offset[:, 1] * sin
    middle[:, 1] += offset[:, 0] * sin + offset[:, 1] * cos
    reach = np.hypot(half[:, 0], half[:, 1]) + BESIDE_M
    row, point = grid.candidates(middle, float(reach.max(initial=0.0)))
    gap = place[point] - middle[row]
    cos, sin = cos[row], sin[row]
    inside = np.abs(gap[:, 0] * cos + gap[:, 1] * sin) <= half[row, 0]
    inside &= np.abs(gap[:, 1] * cos - gap[:, 0] * sin) <= half[row, 1] + BESIDE_M
    inside &= np.abs(gap[:, 2]) <= OTHER_LEVEL_M
    return rows[row[inside]], point[inside]
