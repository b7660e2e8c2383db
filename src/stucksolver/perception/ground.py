"""How high the ground lies around the vehicle, by the LiDAR's own points."""

from __future__ import annotations

import math

import numpy as np

from stucksolver.perception.measurements import Floats

SECTORS = 36
RING_M = 4.0
RINGS = 32
STEEPEST = 0.12
"""Slope that a road has at most; what rises faster stands on the ground."""
ALLOWANCE_M = 0.15
"""Noise, kerbs and the curvature of the road within one ring."""


def ground_heights(azimuth: Floats, distance: Floats, z: Floats) -> Floats:
    """The ground's height below each point, in the frame of `z` (m), beginning with 0 at the vehicle.

    In each sector of 10 degrees one goes outwards in rings of 4 m. The lowest point of a ring is its ground, unless it
    lies higher or lower than a road's slope can lead there from the ring before; then the ground goes on level.

    Args:
        azimuth, distance, z: (n,) each: points around the LiDAR's foot (rad, m, m).
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
    """Linear between the middles of the rings: on a slope, a ring's far end is higher than its near one."""
    place = np.clip(distance / RING_M - 0.5, 0.0, RINGS - 1.001)
    inner = place.astype(np.int64)
    share = place - inner
    below: Floats = heights[sector, inner] * (1.0 - share) + heights[sector, inner + 1] * share
    return below
