"""Compiles the ray loops once, with the types that they are called with."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from carlette.sensors.kernels import label_points, place_points, scan


@lru_cache(maxsize=1)
def warm_up() -> None:
    """Casts one ray at one wall; after that, no call compiles anything."""
    wall = np.array([[(5, -1, -1), (5, -1, 1), (5, 1, 1), (5, 1, -1)]], np.float32)
    nearness, hit, gaps = np.full((1, 1), 0.1, np.float32), np.full((1, 1), -1, np.int32), np.zeros(1, np.float32)
    body = (wall, np.array([[0, 1]]), np.eye(3)[None], np.zeros((1, 3)))
    scan(*body, np.zeros(1), np.zeros((1, 1)), 10.0, 0, nearness, hit, gaps)
    kept, start, flat = np.ones((1, 1), bool), np.zeros(1, np.int64), np.ones((1, 2))
    points, sources = np.empty((1, 4), np.float32), np.empty(1, np.int64)
    place_points(nearness, kept, start, start, flat, flat, np.zeros((0, 0), np.float32), nearness, points, sources)
    of_face, rows = np.zeros(1, np.uint32), np.empty((1, 6), np.float32)
    label_points(points, sources, nearness, hit, gaps, of_face, of_face, rows, rows.view(np.uint32))
