"""Corrects rows of barriers that the network detects as a truck.

A row of barriers across a road is as long as a truck and as straight as its side. But it is lower: a nearby truck
returns as many rays from above its lowest meter as from that meter.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.free_space import footprints, within
from stucksolver_perception.ground import above_ground
from stucksolver_perception.lidar.refinement.barrier_extent import BARRIER
from stucksolver_perception.lidar.refinement.nearby import stationary_nearby
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections
from stucksolver_perception.rig import LidarRig

TRUCK = LABELS.index("truck")
"""Index of the label."""
MARGIN_M = 0.1
"""Margin around the box within which returns come from the object (m). Ours."""
MIN_HEIGHT_M = 0.25
"""Minimum height of the object's returns above the ground (m). Ours."""
LOW_M = 1.2
"""Height that all trucks exceed (m). Ours."""
HIGH_M = 2.2
"""Height up to which the LiDAR's rays hit a truck's side (m). Ours."""
MIN_RETURNS = 20
"""Minimum number of returns. Ours."""
HIGH_SHARE = 0.05
"""Maximum share of a row's returns between `LOW_M` and `HIGH_M`, from a sign or a branch. Ours."""


def with_low_trucks_as_barriers(detections: Detections, turn: NDArray[np.floating], lidar: LidarRig) -> Detections:
    """Return the detections with nearby trucks that are as low as barriers as barriers.

    Args:
        detections: Detections in the vehicle frame.
        turn: (n, 3 or more): x, y, z (m) of the last full turn in the vehicle frame at the same time.
        lidar: Mount of the LiDAR.
    """
    rows = stationary_nearby(detections, (TRUCK,))
    if not len(rows):
        return detections
    x, y, z = (np.asarray(turn[:, axis], np.float64) for axis in range(3))
    above = above_ground(x - lidar.mount.x_m, y - lidar.mount.y_m, z)
    boxes = footprints(np.column_stack([detections.center, detections.size, detections.yaw]))
    label, size, center = detections.label.copy(), detections.size.copy(), detections.center.copy()
    for i in rows:
        heights = above[within(boxes[i][None], x, y, MARGIN_M, MARGIN_M) & (above > MIN_HEIGHT_M) & (above < HIGH_M)]
        if len(heights) >= MIN_RETURNS and (heights > LOW_M).mean() < HIGH_SHARE:
            top_m = float(heights[heights <= LOW_M].max())
            center[i, 2] += (top_m - size[i, 2]) / 2.0
            label[i], size[i, 2] = BARRIER, top_m
    return replace(detections, label=label, center=center, size=size)
