"""Compiles the ray loops once, with the types that they are called with."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from carlette.sensors.kernels import pack_points, scan


@lru_cache(maxsize=1)
def warm_up() -> None:
    """Casts one ray at one wall; after that, no call compiles anything."""
    corners = np.array([[(5, -1, -1), (5, -1, 1), (5, 1, 1), (5, 1, -1)]], np.float32)
    azimuths, tangents = np.zeros(1), np.zeros((1, 1))
    distance, hit = np.full((1, 1), 10.0, np.float32), np.full((1, 1), -1, np.int32)
    spans = np.array([[0, 1]])
    scan(corners, spans, np.eye(3)[None], np.zeros((1, 3)), azimuths, tangents, 10.0, 0, distance, hit)
    points, faces = np.empty((1, 4), np.float32), np.empty(1, np.int32)
    chances, noise = np.zeros((0, 0, 0), np.float32), np.zeros((0, 0), np.float32)
    zeros = np.zeros(1, np.int64)
    pack_points(distance, hit, zeros, zeros, azimuths, tangents[0], np.zeros(5), chances, noise, points, faces)
