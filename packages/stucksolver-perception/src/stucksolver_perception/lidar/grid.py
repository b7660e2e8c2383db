"""Defines the grid around the vehicle: fine cells for pillars, coarse cells for the network's output."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class BevGrid:
    """Two nested grids in the vehicle frame; each coarse cell contains 2 x 2 pillars.

    A row of coarse cells runs along y, and rows follow each other along x. The four pillars of a coarse cell have
    consecutive numbers, 4 * (row * columns + column) + part, so that a reshape joins them.
    """

    x_min_m: float = -70.4
    """Start of the grid behind (m)."""
    y_min_m: float = -44.8
    """Start of the grid on the right (m)."""
    z_min_m: float = -3.0
    """Minimum height of a point (m)."""
    z_max_m: float = 5.0
    """Maximum height of a point (m)."""
    pillar_m: float = 0.32
    """Side of a pillar (m)."""
    rows: int = 240
    """Number of coarse cells along x."""
    columns: int = 140
    """Number of coarse cells along y."""

    @property
    def cell_m(self) -> float:
        """Side of a coarse cell (m)."""
        return 2.0 * self.pillar_m

    @property
    def cells(self) -> int:
        """Number of coarse cells."""
        return self.rows * self.columns

    @property
    def pillars(self) -> int:
        """Number of pillars."""
        return 4 * self.cells

    @property
    def x_max_m(self) -> float:
        """End of the grid ahead (m)."""
        return self.x_min_m + self.rows * self.cell_m

    @property
    def y_max_m(self) -> float:
        """End of the grid on the left (m)."""
        return self.y_min_m + self.columns * self.cell_m


GRID = BevGrid()
"""The grid on which the network was trained: 83 m ahead, 70 m behind, 45 m to the sides."""
EGO_HALF_LENGTH_M = 2.2
"""Half length of the part of the ego whose returns are dropped (m), as in training."""
EGO_HALF_WIDTH_M = 0.9
"""Half width of this part (m)."""
