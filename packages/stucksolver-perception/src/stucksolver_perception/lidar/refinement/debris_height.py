"""Measures the heights of small debris near the vehicle from its returns.

The network has learned the usual size of small debris, and gives 0.25 m for a bag that is 0.12 m high. Near the
vehicle, some dozens of rays in half a second hit debris and the road around it, which gives its height with an error of
a few centimeters. While the vehicle is stopped, the rays may miss a top that is lower than the distance between two
rays (0.09 m at 8 m). While the vehicle approaches, the rays pass over every part of it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections

DEBRIS = LABELS.index("debris")
"""Index of the label."""
NEAR_M = 13.0
"""Maximum distance of measured debris (m). Farther away, too few rays hit an object as low as a bag. Ours."""
MIN_REACH_M, MAX_REACH_M = 0.25, 1.5
"""Bounds of the distance of returns from the center of the debris (m), which is half its length. Ours."""
INNER_M, OUTER_M = 0.2, 0.9
"""Distances beyond those returns between which returns come from the road around (m). Ours."""
MIN_RETURNS, MIN_ROAD_RETURNS = 10, 20
"""Minimum numbers of returns from the debris, and from the road around it. Ours."""
GROUND_M = 0.03
"""Height above the road from which returns come from the debris (m). Ours."""
BARE_M, MIN_BARE = 7.0, 12
"""Maximum distance (m) and minimum number of returns that prove a bare road, if none of them is above the road. At this
distance, rings are up to 0.25 m apart on the road. Ours."""
NOISE_M = 0.02
"""Height by which the highest of many returns may be too low (m). Ours."""


def with_measured_heights(detections: Detections, points: NDArray[np.floating]) -> Detections:
    """Return the detections with the measured heights of small debris that has enough returns.

    Debris with returns from the road only does not exist, and is left out.

    Args:
        detections: Detections in the vehicle frame.
        points: (n, 3 or more): x, y, z (m) of the last sweeps in the vehicle frame at the same time.
    """
    center, size = detections.center.copy(), detections.size.copy()
    is_measured, exists = np.zeros(len(detections), np.bool_), np.ones(len(detections), np.bool_)
    for i in np.flatnonzero(detections.label == DEBRIS):
        if np.hypot(center[i, 0], center[i, 1]) > NEAR_M:
            continue
        reach = float(np.clip(size[i, :2].max() / 2.0, MIN_REACH_M, MAX_REACH_M))
        distance = np.hypot(points[:, 0] - center[i, 0], points[:, 1] - center[i, 1])
        road = points[(distance > reach + INNER_M) & (distance < reach + OUTER_M), 2]
        if len(road) < MIN_ROAD_RETURNS:
            continue
        ground = float(np.median(road))
        inside = points[distance < reach, 2] - ground
        above = inside[inside > GROUND_M]
        exists[i] = len(above) > 0 or len(inside) < MIN_BARE or np.hypot(center[i, 0], center[i, 1]) > BARE_M
        if len(above) >= MIN_RETURNS:
            size[i, 2] = float(above.max()) + NOISE_M
            center[i, 2], is_measured[i] = ground + size[i, 2] / 2.0, True
    return replace(detections, center=center, size=size, height_known=is_measured).part(np.flatnonzero(exists))
