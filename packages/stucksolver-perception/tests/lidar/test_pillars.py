"""Points to pillars."""

import numpy as np

from stucksolver_perception.lidar.grid import GRID
from stucksolver_perception.lidar.pillars import FEATURES, occupied, pillars


def points_at(*places: tuple[float, float, float]) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
    return np.array([(*place, 0.4, 0.1) for place in places], np.float32)


def test_a_point_is_told_from_the_middle_of_its_pillar() -> None:
    features, cell = pillars(points_at((10.1, -3.2, 0.7)))
    rest, part = divmod(int(cell[0]), 4)
    row, column = divmod(rest, GRID.columns)
    x = GRID.x_min_m + row * GRID.cell_m + (part // 2 + 0.5) * GRID.pillar_m
    y = GRID.y_min_m + column * GRID.cell_m + (part % 2 + 0.5) * GRID.pillar_m
    assert features.shape == (1, FEATURES)
    np.testing.assert_allclose(features[0, :2] * GRID.pillar_m / 2, [10.1 - x, -3.2 - y], atol=1e-4)
    assert np.abs(features[0, :2]).max() <= 1.001


def test_every_pillar_of_the_grid_has_its_own_number() -> None:
    steps_x = GRID.x_min_m + GRID.pillar_m * (np.arange(2 * GRID.rows) + 0.5)
    steps_y = GRID.y_min_m + GRID.pillar_m * (np.arange(2 * GRID.columns) + 0.5)
    x, y = (item.ravel() for item in np.meshgrid(steps_x, steps_y))
    places = np.stack([x, y, *np.zeros((3, len(x)))], axis=1).astype(np.float32)
    _, cell = pillars(places)
    # A few pillars lie in our own body and have no points.
    assert len(np.unique(cell)) == len(cell) > 0.99 * GRID.pillars
    assert cell.min() >= 0 and cell.max() < GRID.pillars


def test_pillars_leave_out_points_outside_grid_and_on_ego() -> None:
    """Points beyond the grid and on the ego's body are left out."""
    outside = points_at((90, 0, 0), (0, 50, 0), (20, 0, 6), (20, 0, -4), (1.0, 0.5, 1.0))
    assert len(pillars(outside)[1]) == 0
    assert len(pillars(points_at((1.0, 1.2, 0.5)))[1]) == 1


def test_no_points_make_no_pillars() -> None:
    features, cell = pillars(np.zeros((0, 5), np.float32))
    assert features.shape == (0, FEATURES) and cell.shape == (0,)


def test_occupied_numbers_cells_without_gaps_and_keeps_parts() -> None:
    """Occupied cells are numbered without gaps, and pillars keep their part."""
    _, cell = pillars(points_at((30.1, 4.0, 0.2), (30.4, 4.0, 0.2), (-20.0, -3.0, 0.2), (30.1, 4.0, 1.2)))
    slot, cells = occupied(cell)
    assert cells.tolist() == sorted(set((cell // 4).tolist()))
    np.testing.assert_array_equal(cells[slot // 4], cell // 4)
    np.testing.assert_array_equal(slot % 4, cell % 4)
