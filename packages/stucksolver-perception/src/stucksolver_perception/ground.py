"""The height of the ground around the vehicle, from the LiDAR's own points."""

from __future__ import annotations

import math

import numpy as np

from stucksolver_perception.measurements import Floats

SECTORS = 36
RING_M = 4.0
RINGS = 32
STEEPEST = 0.12
"""Steepest slope of a road; anything steeper stands on the ground."""
ALLOWANCE_M = 0.15
"""Noise, curbs and the curvature of the road within one ring."""


STEP_M = 0.3
"""Lower points are another surface, such as a field or a ditch beside the road, if this much between them is empty: on
a slope the LiDAR's lines follow each other more closely.
"""
FEW = 2
"""Points that continue a surface."""


def above_ground(x: Floats, y: Floats, z: Floats) -> Floats:
    """(n,): heights above the ground of points around the LiDAR's foot (m), see `ground_heights`."""
    return z - ground_heights(np.arctan2(y, x), np.hypot(x, y), z)


def ground_heights(azimuth: Floats, distance: Floats, z: Floats) -> Floats:
    """Return the ground's height below each point, in the frame of `z` (m), beginning with 0 at the vehicle.

    Each sector of 10 degrees is followed outward in rings of 4 m. The lowest point of a ring is its ground, unless a
    road's slope cannot lead there from the previous ring; the ground then continues level. Where the road and something
    lower beside it lie in one ring, the surface of the previous ring counts; the other one is lower than the ground.

    Args:
        azimuth: (n,) azimuths of points around the LiDAR's foot (rad).
        distance: (n,) their distances (m).
        z: (n,) their heights (m).
    """
    sector = np.minimum(((azimuth + math.pi) / math.tau * SECTORS).astype(np.int64), SECTORS - 1)
    ring = np.minimum((distance / RING_M).astype(np.int64), RINGS - 1)
    lowest = np.full((SECTORS, RINGS), np.inf)
    np.minimum.at(lowest, (sector, ring), z)
    order = np.argsort(ring.astype(np.uint8), kind="stable")  # bytes are sorted by radix, five times as fast
    ends = np.searchsorted(ring[order], np.arange(RINGS + 1))
    heights = np.zeros((SECTORS, RINGS))
    level = np.zeros(SECTORS)
    slope = np.zeros(SECTORS)
    unseen_m = np.zeros(SECTORS)
    for i in range(RINGS):
        unseen_m = unseen_m + RING_M
        possible = np.abs(lowest[:, i] - level) <= STEEPEST * unseen_m + ALLOWANCE_M
        same = np.full(SECTORS, np.inf)
        split = lowest[:, i] < level + slope * RING_M - STEP_M
        if split.any():
            here = order[ends[i] : ends[i + 1]]
            here = here[split[sector[here]]]
            # The lowest point of a ring is at its near end where the road rises, and at its far end where it falls.
            from_m = RING_M * np.where(slope > 0.0, i - 1, i)
            off = z[here] - level[sector[here]] - slope[sector[here]] * (distance[here] - from_m[sector[here]])
            same = _same_surface(sector[here], z[here], off)
        found = possible | np.isfinite(same)
        before, level = level, np.where(np.isfinite(same), same, np.where(possible, lowest[:, i], level))
        slope = np.where(found, np.clip((level - before) / unseen_m, -STEEPEST, STEEPEST), slope)
        unseen_m = np.where(found, 0.0, unseen_m)
        heights[:, i] = level
    return _between(heights, sector, distance)


def _same_surface(sector: np.ndarray, z: Floats, off: Floats) -> Floats:
    """(SECTORS,): lowest point of the surface that continues, if only something clearly lower is below it; inf if not.

    `off` is how much higher than that surface each point of the ring is.
    """
    found = np.full(SECTORS, np.inf)
    near = np.abs(off) <= ALLOWANCE_M
    edge = np.full(SECTORS, np.inf)
    np.minimum.at(edge, sector[near], off[near])
    np.minimum.at(found, sector[near], z[near])
    between = (off < edge[sector]) & (off > edge[sector] - STEP_M)
    counts = np.bincount(sector[near], minlength=SECTORS)
    found[(counts < FEW) | (np.bincount(sector[between], minlength=SECTORS) > 0)] = np.inf
    return found


def _between(heights: Floats, sector: np.ndarray, distance: Floats) -> Floats:
    """Interpolate between the middles of the rings: on a slope, a ring's far end is higher than its near one."""
    place = np.clip(distance / RING_M - 0.5, 0.0, RINGS - 1.001)
    inner = place.astype(np.int64)
    share = place - inner
    below: Floats = heights[sector, inner] * (1.0 - share) + heights[sector, inner + 1] * share
    return below
