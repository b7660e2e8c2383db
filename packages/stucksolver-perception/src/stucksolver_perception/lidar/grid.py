"""The ground around the vehicle as cells: fine ones for pillars, coarse ones for the answers."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class BevGrid:
    """Two nested grids in the vehicle frame; each coarse cell holds 2 x 2 pillars.

    A row of coarse cells runs along y, and rows follow each other along x. Pillars are numbered so that the four of a
    coarse cell follow each other, 4 * (row * columns + column) + part: a reshape makes one coarse cell of them.
    """

    x_min_m: float = -70.4
    y_min_m: float = -44.8
    z_min_m: float = -3.0
    z_max_m: float = 5.0
    pillar_m: float = 0.32
    rows: int = 240
    """Number of coarse cells along x."""
    columns: int = 140
    """Number of coarse cells along y."""

    @property
    def cell_m(self) -> float:
        """Side of a coarse cell."""
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
EGO_HALF_WIDTH_M = 0.9
"""Returns from within this part of our own body are dropped."""
