"""Measures the near ends of stationary vehicles from their returns.

The network learns lengths of vehicles, and estimates their centers. A vehicle that is longer than most begins up to
half a meter nearer than in its box, and the gap to it is smaller by as much. Rays from the near end show its position.
The far end is that of the network.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.ground import above_ground
from stucksolver_perception.lidar.refinement.nearby import NEAR_M, stationary_nearby
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections, Floats
from stucksolver_perception.rig import LidarRig

VEHICLES = (LABELS.index("car"), LABELS.index("truck"))
"""Indices of the labels."""
LOW_M, HIGH_M = 0.35, 1.6
"""Heights above the ground between which returns come from bumper, hood or trunk, not from the road or the roof (m).
Ours."""
SEARCH_AHEAD_M, SEARCH_BEHIND_M = 0.9, 1.0
"""Distances before and behind the end of the network's box within which the end is searched (m). Ours."""
STRIP_M = 0.25
"""Width of the strips into which the end is divided (m). Ours."""
MIN_FILLED = 0.6
"""Minimum share of the strips with returns. A pedestrian before the vehicle fills fewer. Ours."""
NEARER_SHARE = 0.6
"""Share of the strips that begin farther away than the end, because bumpers are round, and a pedestrian may stand
before one corner. Ours."""
FRONT_MARGIN_M = 0.05
"""Distance by which the end may be before its returns (m). Ours."""


def with_measured_ends(detections: Detections, turn: NDArray[np.floating], lidar: LidarRig) -> Detections:
    """Return the detections with measured near ends of nearby stationary vehicles.

    Args:
        detections: Detections in the vehicle frame.
        turn: (n, 3 or more): x, y, z (m) of the last full turn in the vehicle frame at the same time.
        lidar: Mount of the LiDAR.
    """
    rows = stationary_nearby(detections, VEHICLES)
    if not len(rows):
        return detections
    foot = np.array([lidar.mount.x_m, lidar.mount.y_m])
    positions = np.asarray(turn[:, :2], np.float64) - foot
    is_near = np.hypot(*positions.T) < NEAR_M
    positions = positions[is_near]
    above = above_ground(positions[:, 0], positions[:, 1], np.asarray(turn[is_near, 2], np.float64))
    positions = positions[(above > LOW_M) & (above < HIGH_M)]
    center, size = detections.center.copy(), detections.size.copy()
    for i in rows:
        axis = np.array([math.cos(detections.yaw[i]), math.sin(detections.yaw[i])])
        center_xy = center[i, :2] - foot
        if float(center_xy @ axis) > 0.0:
            axis = -axis  # The axis points to the end that faces the LiDAR.
        half_m = float(size[i, 0]) / 2.0
        if float(-center_xy @ axis) < half_m + SEARCH_AHEAD_M:
            continue  # No end of a vehicle next to the LiDAR is visible.
        end_m = _near_end_m(positions - center_xy, axis, half_m, float(size[i, 1]))
        if end_m is not None:
            center[i, :2] += axis * (end_m - half_m) / 2.0
            size[i, 0] = half_m + end_m
    return replace(detections, center=center, size=size)


def _near_end_m(positions: Floats, axis: Floats, half_m: float, width_m: float) -> float | None:
    """Return the distance of the end in the direction `axis` from the box's center (m); None with too few returns.

    The positions (n, 2) are relative to this center.
    """
    along, across = positions @ axis, positions @ np.array([-axis[1], axis[0]])
    strips = max(int(width_m / STRIP_M), 1)
    near_end = (np.abs(across) < width_m / 2.0) & (along > half_m - SEARCH_BEHIND_M) & (along < half_m + SEARCH_AHEAD_M)
    strip = ((across[near_end] / width_m + 0.5) * strips).astype(np.int64)
    ends = np.full(strips, -np.inf)
    np.maximum.at(ends, strip, along[near_end])
    ends = np.sort(ends[np.isfinite(ends)])
    if len(ends) < MIN_FILLED * strips:
        return None
    return float(ends[min(int(NEARER_SHARE * len(ends)), len(ends) - 1)]) + FRONT_MARGIN_M
