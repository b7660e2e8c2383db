"""Where the near end of a standing vehicle is, measured by the returns from it.

The network learns lengths of vehicles, and places their middles. A vehicle that is longer than most begins up to half
a meter nearer than the network says, and a gap to it is as much smaller. Rays from its end show where it is; the far
end stays where the network says.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.ground import above_ground
from stucksolver_perception.lidar.refinement.nearby import NEAR_M, standing_nearby
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections, Floats
from stucksolver_perception.rig import LidarRig

VEHICLES = (LABELS.index("car"), LABELS.index("truck"))
LOW_M, HIGH_M = 0.35, 1.6
"""Returns between these heights above the ground come from bumper, bonnet or boot, not from the road or the roof."""
BEFORE_M, BEHIND_M = 0.9, 1.0
"""The end is looked for so far before and behind that of the network's box."""
STRIP_M = 0.25
"""The end is divided into strips of this width."""
FILLED = 0.6
"""This share of the strips must have returns: a person before the vehicle fills fewer."""
NEARER_SHARE = 0.6
"""This share of the strips begins farther away: bumpers are round, and a person may stand before one corner."""
BEFORE_RETURNS_M = 0.05
"""The end may be this far before its returns."""


def with_measured_ends(detections: Detections, turn: NDArray[np.floating], lidar: LidarRig) -> Detections:
    """Return the detections; standing vehicles nearby begin where the returns from their near end are.

    Args:
        detections: In the vehicle frame.
        turn: (n, 3 or more): x, y, z (m) of the last full turn in the vehicle frame at the same time.
        lidar: Where the LiDAR is mounted.
    """
    which = standing_nearby(detections, VEHICLES)
    if not len(which):
        return detections
    foot = np.array([lidar.mount.x_m, lidar.mount.y_m])
    places = np.asarray(turn[:, :2], np.float64) - foot
    near = np.hypot(*places.T) < NEAR_M
    places = places[near]
    above = above_ground(places[:, 0], places[:, 1], np.asarray(turn[near, 2], np.float64))
    places = places[(above > LOW_M) & (above < HIGH_M)]
    center, size = detections.center.copy(), detections.size.copy()
    for i in which:
        axis = np.array([math.cos(detections.yaw[i]), math.sin(detections.yaw[i])])
        middle = center[i, :2] - foot
        if float(middle @ axis) > 0.0:
            axis = -axis  # it points to the end that faces the LiDAR
        half_m = float(size[i, 0]) / 2.0
        if float(-middle @ axis) < half_m + BEFORE_M:
            continue  # beside the LiDAR no end is seen
        end_m = _end(places - middle, axis, half_m, float(size[i, 1]))
        if end_m is not None:
            center[i, :2] += axis * (end_m - half_m) / 2.0
            size[i, 0] = half_m + end_m
    return replace(detections, center=center, size=size)


def _end(places: Floats, axis: Floats, half_m: float, width_m: float) -> float | None:
    """Return how far from the middle the end that `axis` points to is (m); None if too little of it is seen.

    `places` (n, 2) are around the box's middle.
    """
    along, across = places @ axis, places @ np.array([-axis[1], axis[0]])
    strips = max(int(width_m / STRIP_M), 1)
    here = (np.abs(across) < width_m / 2.0) & (along > half_m - BEHIND_M) & (along < half_m + BEFORE_M)
    strip = ((across[here] / width_m + 0.5) * strips).astype(np.int64)
    ends = np.full(strips, -np.inf)
    np.maximum.at(ends, strip, along[here])
    ends = np.sort(ends[np.isfinite(ends)])
    if len(ends) < FILLED * strips:
        return None
    return float(ends[min(int(NEARER_SHARE * len(ends)), len(ends) - 1)]) + BEFORE_RETURNS_M
