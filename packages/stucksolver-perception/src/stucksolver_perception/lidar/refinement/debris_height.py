"""Heights of small things on the road nearby, measured by the returns from them.

The network learns the usual size of small debris, and says 0.25 m of a bag that is 0.12 m high. Near the vehicle some
dozens of rays of half a second hit such a thing and the road around it: they tell its height to a few centimeters. What
stands up by less than the distance between two rays of a standing vehicle (0.09 m at 8 m) may be missed at its top;
while the vehicle comes nearer, the rays pass over every part of it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections

DEBRIS = LABELS.index("debris")
NEAR_M = 13.0
"""Farther away, too few rays meet something as low as a bag."""
LEAST_REACH_M, MOST_REACH_M = 0.25, 1.5
"""Its returns lie within half its length around its middle, but at least and at most this far away."""
BESIDE_M, AROUND_M = 0.2, 0.9
"""The road around it: from the first distance beyond its returns to the second."""
FEWEST, FEWEST_AROUND = 10, 20
"""Returns from it, and from the road around it."""
GROUND_M = 0.03
"""Returns that are higher above the road come from the thing."""
BARE_M, BARE = 7.0, 12
"""So near, rings are up to 0.25 m apart on the road. This many returns from a place, none of them higher than the road,
show that nothing is there.
"""
NOISE_M = 0.02
"""The highest of many returns may still be that much too low."""


def with_measured_heights(detections: Detections, points: NDArray[np.floating]) -> Detections:
    """Return the detections, with the measured height of each small debris that has enough returns.

    Where only the road returned rays, there is none: its detection is left out.

    Args:
        detections: In the vehicle frame.
        points: (n, 3 or more): x, y, z (m) of the last sweeps in the vehicle frame at the same time.
    """
    center, size = detections.center.copy(), detections.size.copy()
    known, there = np.zeros(len(detections), np.bool_), np.ones(len(detections), np.bool_)
    for i in np.flatnonzero(detections.label == DEBRIS):
        if np.hypot(center[i, 0], center[i, 1]) > NEAR_M:
            continue
        reach = float(np.clip(size[i, :2].max() / 2.0, LEAST_REACH_M, MOST_REACH_M))
        away = np.hypot(points[:, 0] - center[i, 0], points[:, 1] - center[i, 1])
        around = points[(away > reach + BESIDE_M) & (away < reach + AROUND_M), 2]
        if len(around) < FEWEST_AROUND:
            continue
        ground = float(np.median(around))
        inside = points[away < reach, 2] - ground
        above = inside[inside > GROUND_M]
        there[i] = len(above) > 0 or len(inside) < BARE or np.hypot(center[i, 0], center[i, 1]) > BARE_M
        if len(above) >= FEWEST:
            size[i, 2] = float(above.max()) + NOISE_M
            center[i, 2], known[i] = ground + size[i, 2] / 2.0, True
    return replace(detections, center=center, size=size, height_known=known).part(np.flatnonzero(there))
