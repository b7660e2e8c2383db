"""Persons whom the network sees in the side of a vehicle.

Where the LiDAR looks along the side of a van, few rays return, from its edges. The network takes them for a person at
times, half inside the van. Somebody who stands there returns dozens of rays.
"""

from __future__ import annotations

import numpy as np

from stucksolver_perception.free_space import EGO_HALF_LENGTH_M, footprints, within
from stucksolver_perception.lidar.refinement.unexplained_returns import AHEAD_M, ASIDE_M
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections, Floats

BESIDE_M = 0.5
"""Who is nearer than this to the side of a vehicle's box may be partly inside the vehicle: half a body, and the box's
error."""
SIDE_ERROR_M = 0.1
"""The vehicle's own returns may lie this far outside its box."""
REACH_M = 0.4
"""From the middle of a person's box to the outermost return: half a body, and the box's error."""
FEWEST = 4
"""Returns of a person in one turn. A person at 16 m has about 25 of the shipped LiDAR; in the sides of vans there are
none to two."""

PEDESTRIAN = LABELS.index("pedestrian")


def drop_false_pedestrians(detections: Detections, standing: Floats, known: Floats) -> Detections:
    """Return the detections without the persons close ahead who are at a vehicle's side and return hardly any rays.

    Args:
        detections: In the vehicle frame.
        standing: What `residual.standing_returns` found, at the same time.
        known: (k, 8): tracked vehicles, see `residual.with_unexplained`.
    """
    x, y = detections.center[:, 0], detections.center[:, 1]
    # Around the others not all returns are in `standing`.
    near = (x > EGO_HALF_LENGTH_M + REACH_M) & (x < AHEAD_M - REACH_M) & (np.abs(y) < ASIDE_M - REACH_M)
    bodies = footprints(np.reshape(known, (-1, 8)))
    doubtful = near & (detections.label == PEDESTRIAN) & within(bodies, x, y, BESIDE_M, BESIDE_M)
    if not doubtful.any():
        return detections
    outside = standing[~within(bodies, standing[:, 0], standing[:, 1], SIDE_ERROR_M, SIDE_ERROR_M)]
    away = np.hypot(x[doubtful, None] - outside[:, 0], y[doubtful, None] - outside[:, 1])
    kept = ~doubtful
    kept[doubtful] = (away < REACH_M).sum(axis=1) >= FEWEST
    return detections.part(np.flatnonzero(kept))
