"""The height of the ground around the vehicle, from the LiDAR's own points."""

from __future__ import annotations

import math

import numpy as np

from stucksolver.perception.measurements import Floats

SECTORS = 36
RING_M = 4.0
RINGS = 32
STEEPEST = 0.12
"""Steepest slope of a road; anything steeper stands on the ground."""
ALLOWANCE_M = 0.15
"""Noise, kerbs and the curvature of the road within one ring."""


def ground_heights(azimuth: Floats, distance: Floats, z: Floats) -> Floats:
    """Return the ground's height below each point, in the frame of `z` (m), beginning with 0 at the vehicle.

    Each sector of 10 degrees is followed outwards in rings of 4 m. The lowest point of a ring is its ground, unless a
    road's slope cannot lead there from the previous ring; the ground then continues level.

    Args:
        azimuth: (n,) azimuths of points around the LiDAR's foot (rad).
        distance: (n,) their distances (m).
        z: (n,) their heights (m).
    """
    sector = np.minimum(((azimuth + math.pi) / math.tau * SECTORS).astype(np.int64), SECTORS - 1)
    ring = np.minimum((distance / RING_M).astype(np.int64), RINGS - 1)
    lowest = np.full((SECTORS, RINGS), np.inf)
    np.minimum.at(lowest, (sector, ring), z)
    heights = np.zeros((SECTORS, RINGS))
    level = np.zeros(SECTORS)
    unseen_m = np.zeros(SECTORS)
    for i in range(RINGS):
        unseen_m = unseen_m + RING_M
        possible = np.abs(lowest[:, i] - level) <= STEEPEST * unseen_m + ALLOWANCE_M
        level = np.where(possible, lowest[:, i], level)
        unseen_m = np.where(possible, 0.0, unseen_m)
        heights[:, i] = level
    return _between(heights, sector, distance)


def _between(heights: Floats, sector: np.ndarray, distance: Floats) -> Floats:
    """Interpolate between the middles of the rings: on a slope, a ring's far end is higher than its near one."""
    place = np.clip(distance / RING_M - 0.5, 0.0, RINGS - 1.001)
    inner = place.astype(np.int64)
    share = place - inner
    below: Floats = heights[sector, inner] * (1.0 - share) + heights[sector, inner + 1] * share
    return below
