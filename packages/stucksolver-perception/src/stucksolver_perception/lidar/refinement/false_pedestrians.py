"""Removes false pedestrian detections at the sides of vehicles.

When the LiDAR's rays pass along the side of a van, few of them return, from its edges. The network sometimes detects
them as a pedestrian, half inside the van. A real pedestrian there returns dozens of rays.
"""

from __future__ import annotations

import numpy as np

from stucksolver_perception.free_space import EGO_HALF_LENGTH_M, footprints, within
from stucksolver_perception.lidar.refinement.unexplained_returns import AHEAD_M, LATERAL_M
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections, Floats

SIDE_M = 0.5
"""Distance from a vehicle's box within which a detection may be partly inside the vehicle (m): half a body, and the
box's error."""
SIDE_ERROR_M = 0.1
"""Margin around a vehicle's box within which returns come from the vehicle (m). Ours."""
REACH_M = 0.4
"""Distance from a pedestrian box's center to its outermost return (m): half a body, and the box's error."""
MIN_RETURNS = 4
"""Minimum number of a pedestrian's returns in one turn. A pedestrian at 16 m has about 25 with the shipped LiDAR; false
detections at vans have none to two."""

PEDESTRIAN = LABELS.index("pedestrian")
"""Index of the label."""


def drop_false_pedestrians(detections: Detections, standing: Floats, vehicles: Floats) -> Detections:
    """Return the detections without pedestrians close ahead at a vehicle's side that have too few returns.

    Args:
        detections: Detections in the vehicle frame.
        standing: Result of `unexplained_returns.standing_returns` at the same time.
        vehicles: (k, 8): tracked vehicles; see `unexplained_returns.with_unexplained`.
    """
    x, y = detections.center[:, 0], detections.center[:, 1]
    # Around detections farther out, not all returns are in `standing`.
    is_near = (x > EGO_HALF_LENGTH_M + REACH_M) & (x < AHEAD_M - REACH_M) & (np.abs(y) < LATERAL_M - REACH_M)
    vehicle_footprints = footprints(np.reshape(vehicles, (-1, 8)))
    is_doubtful = is_near & (detections.label == PEDESTRIAN) & within(vehicle_footprints, x, y, SIDE_M, SIDE_M)
    if not is_doubtful.any():
        return detections
    returns = standing[~within(vehicle_footprints, standing[:, 0], standing[:, 1], SIDE_ERROR_M, SIDE_ERROR_M)]
    distance = np.hypot(x[is_doubtful, None] - returns[:, 0], y[is_doubtful, None] - returns[:, 1])
    remains = ~is_doubtful
    remains[is_doubtful] = (distance < REACH_M).sum(axis=1) >= MIN_RETURNS
    return detections.part(np.flatnonzero(remains))
