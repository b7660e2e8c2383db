"""Computes the height of the ground around the vehicle from the LiDAR's points."""

from __future__ import annotations

import math

import numpy as np

from stucksolver_perception.measurements import Floats

SECTORS = 36
"""Number of directions, 10 degrees each. Ours."""
RING_M = 4.0
"""Width of a ring (m). Ours."""
RINGS = 32
"""Number of rings: up to 128 m. Ours."""
MAX_SLOPE = 0.12
"""Maximum slope of a road; steeper points belong to an object. Ours."""
ALLOWANCE_M = 0.15
"""Allowance for noise, curbs and the curvature of the road within one ring (m). Ours."""
EMPTY_M = 0.3
"""Empty height between two surfaces, such as a road and the field or ditch next to it (m). On a slope, the points of
the LiDAR's lines are closer together. Ours."""
MIN_POINTS = 2
"""Minimum number of points that continue a surface. Ours."""


def above_ground(x: Floats, y: Floats, z: Floats) -> Floats:
    """Return (n,): heights above the ground of points around the LiDAR's foot (m); see `ground_heights`."""
    return z - ground_heights(np.arctan2(y, x), np.hypot(x, y), z)


def ground_heights(azimuth: Floats, distance: Floats, z: Floats) -> Floats:
    """Return (n,): the ground's height below each point, in the frame of `z` (m). It is 0 at the vehicle.

    Each sector of 10 degrees is followed outward in rings of 4 m. The lowest point of a ring is its ground, unless the
    slope from the previous ring would be too steep for a road. Then the ground continues level. If a ring contains the
    road and a lower surface next to it, the surface of the previous ring continues.

    Args:
        azimuth: (n,): azimuths of points around the LiDAR's foot (rad).
        distance: (n,): their distances (m).
        z: (n,): their heights (m).
    """
    sector = np.minimum(((azimuth + math.pi) / math.tau * SECTORS).astype(np.int64), SECTORS - 1)
    ring = np.minimum((distance / RING_M).astype(np.int64), RINGS - 1)
    lowest = np.full((SECTORS, RINGS), np.inf)
    np.minimum.at(lowest, (sector, ring), z)
    order = np.argsort(ring.astype(np.uint8), kind="stable")  # numpy sorts bytes by radix, five times as fast
    ends = np.searchsorted(ring[order], np.arange(RINGS + 1))
    heights = np.zeros((SECTORS, RINGS))
    level = np.zeros(SECTORS)
    slope = np.zeros(SECTORS)
    since_ground_m = np.zeros(SECTORS)
    for i in range(RINGS):
        since_ground_m = since_ground_m + RING_M
        is_possible = np.abs(lowest[:, i] - level) <= MAX_SLOPE * since_ground_m + ALLOWANCE_M
        continued = np.full(SECTORS, np.inf)
        has_lower = lowest[:, i] < level + slope * RING_M - EMPTY_M
        if has_lower.any():
            points = order[ends[i] : ends[i + 1]]
            points = points[has_lower[sector[points]]]
            # The lowest point of a ring is at its near end if the road rises, and at its far end if it falls.
            from_m = RING_M * np.where(slope > 0.0, i - 1, i)
            of_point = sector[points]
            difference = z[points] - level[of_point] - slope[of_point] * (distance[points] - from_m[of_point])
            continued = _continued_surface(of_point, z[points], difference)
        has_ground = is_possible | np.isfinite(continued)
        before, level = level, np.where(np.isfinite(continued), continued, np.where(is_possible, lowest[:, i], level))
        slope = np.where(has_ground, np.clip((level - before) / since_ground_m, -MAX_SLOPE, MAX_SLOPE), slope)
        since_ground_m = np.where(has_ground, 0.0, since_ground_m)
        heights[:, i] = level
    return _interpolated(heights, sector, distance)


def _continued_surface(sector: np.ndarray, z: Floats, difference: Floats) -> Floats:
    """Return (SECTORS,): the lowest point of the surface that continues (m).

    The result is infinite without such a surface, or if the space below it is not empty. `difference` is the height of
    each point of the ring above the continued surface (m).
    """
    lowest = np.full(SECTORS, np.inf)
    on_surface = np.abs(difference) <= ALLOWANCE_M
    edge = np.full(SECTORS, np.inf)
    np.minimum.at(edge, sector[on_surface], difference[on_surface])
    np.minimum.at(lowest, sector[on_surface], z[on_surface])
    between = (difference < edge[sector]) & (difference > edge[sector] - EMPTY_M)
    counts = np.bincount(sector[on_surface], minlength=SECTORS)
    lowest[(counts < MIN_POINTS) | (np.bincount(sector[between], minlength=SECTORS) > 0)] = np.inf
    return lowest


def _interpolated(heights: Floats, sector: np.ndarray, distance: Floats) -> Floats:
    """Return (n,): heights between the centers of the rings. On a slope, a ring's far end is higher than its near
    end.
    """
    position = np.clip(distance / RING_M - 0.5, 0.0, RINGS - 1.001)
    inner = position.astype(np.int64)
    share = position - inner
    below: Floats = heights[sector, inner] * (1.0 - share) + heights[sector, inner + 1] * share
    return below
