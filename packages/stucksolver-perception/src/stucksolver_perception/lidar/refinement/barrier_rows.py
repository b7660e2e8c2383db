"""Rows of barriers that the network takes for a truck.

Barriers that stand end to end across a road are as long as a truck and as straight as its side. But they are lower:
from nearby, many rays come back from the lowest meter of a truck, and as many from above it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.free_space import footprints, within
from stucksolver_perception.ground import above_ground
from stucksolver_perception.lidar.refinement.barrier_extent import BARRIER
from stucksolver_perception.lidar.refinement.nearby import standing_nearby
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections
from stucksolver_perception.rig import LidarRig

TRUCK = LABELS.index("truck")
MARGIN_M = 0.1
STANDS_M = 0.25
"""Returns from this height above the ground on come from the thing (m)."""
LOW_M = 1.2
"""No vehicle ends lower (m)."""
HIGH_M = 2.2
"""The LiDAR sees all of a truck's side up to this height (m)."""
FEWEST = 20
HIGH_SHARE = 0.05
"""Share of the returns between `LOW_M` and `HIGH_M`: a sign, or a branch."""


def with_low_trucks_as_barriers(detections: Detections, turn: NDArray[np.floating], lidar: LidarRig) -> Detections:
    """Return the detections; a truck nearby that is no higher than a barrier has become one.

    Args:
        detections: In the vehicle frame.
        turn: (n, 3 or more): x, y, z (m) of the last full turn in the vehicle frame at the same time.
        lidar: Where the LiDAR is mounted.
    """
    which = standing_nearby(detections, (TRUCK,))
    if not len(which):
        return detections
    x, y, z = (np.asarray(turn[:, axis], np.float64) for axis in range(3))
    above = above_ground(x - lidar.mount.x_m, y - lidar.mount.y_m, z)
    places = footprints(np.column_stack([detections.center, detections.size, detections.yaw]))
    label, size, center = detections.label.copy(), detections.size.copy(), detections.center.copy()
    for i in which:
        own = above[within(places[i][None], x, y, MARGIN_M, MARGIN_M) & (above > STANDS_M) & (above < HIGH_M)]
        if len(own) >= FEWEST and (own > LOW_M).mean() < HIGH_SHARE:
            top_m = float(own[own <= LOW_M].max())
            center[i, 2] += (top_m - size[i, 2]) / 2.0
            label[i], size[i, 2] = BARRIER, top_m
    return replace(detections, label=label, center=center, size=size)
