"""People who stand close to somebody whom the detector named.

Two people half a meter apart are often one box to the network, on one of them or between both. The other one's rays
came back, too. So near the vehicle what stands beside a person, further from its middle than a body reaches, is
another one. A walking person is not wider than that above the knees.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.free_space import footprints, within
from stucksolver_perception.lidar.refinement.clusters import clusters_of, with_standing
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections, Floats

AHEAD_M = (1.5, 6.0)
"""From beside the nose on, and as far as the road is as level as under the vehicle, and a person has hundreds of
returns.
"""
ASIDE_M = 3.0
OWN_LENGTH_M, OWN_WIDTH_M = 2.5, 1.0
"""Half sizes: returns from within come from the vehicle itself. Closer than `visibility.OWN_LENGTH_M`: who leans on the
bumper must be seen, and in front of the doors nothing of the body sticks out."""
LOW_M, HIGH_M = 0.7, 2.0
"""Height above the vehicle's road (m): not the legs, which reach further in a stride."""
BODY_M = 0.4
"""From the middle of a box to the outermost return of its person: half a body, and the box's error."""
OUT_M, OUT = 0.5, 4
"""As many returns of another person are further than this from the named one (m): an elbow, or a coat, is not."""
BESIDE_M = 1.0
"""Further from everybody, `residual` asks what it is."""
LAG_S = 0.2
"""The box of who moves may lag by as much."""
EXPLAINS = 0.2
"""Score from which a detection explains the returns around it."""
MARGIN_M = 0.4
"""Boxes of anything else are this much smaller than what they stand for."""
FEWEST, SHARE = 10, 0.1
"""Returns that make another person: this many, and this share of those from the named one."""
TALL_M = 0.3
"""They extend over this height."""
CELL_M = 0.2
SIZE_M = 0.5
HEIGHT_M = 1.7
SCORE = 0.5
"""As for the obstacles of `residual`: two of these confirm a track."""

PEDESTRIAN = LABELS.index("pedestrian")


def add_close_pedestrians(detections: Detections, points: NDArray[np.floating], known: Floats) -> Detections:
    """Return the detections, and after them those who stand close to a detected person.

    Args:
        detections: In the vehicle frame.
        points: (n, 3 or more): x, y, z (m) of one full turn in the vehicle frame.
        known: (k, 8): tracked vehicles, see `residual.with_unexplained`.
    """
    sure = detections.score >= EXPLAINS
    person = sure & (detections.label == PEDESTRIAN)
    middle = detections.center[person, :2]
    if not len(middle):
        return detections
    reach = BODY_M + LAG_S * np.hypot(*detections.velocity[person].T)
    others = np.column_stack([detections.center, detections.size, detections.yaw])[sure & ~person]
    x, y, z = _close(points)
    away = np.hypot(x[:, None] - middle[:, 0], y[:, None] - middle[:, 1])
    own = (away < reach).any(axis=1)
    bodies = footprints(np.vstack([others, np.reshape(known, (-1, 8))[:, :7]]))
    left = ~own & (away < BESIDE_M).any(axis=1) & ~within(bodies, x, y, MARGIN_M, MARGIN_M)
    if left.sum() < FEWEST:
        return detections
    returns = np.column_stack([x, y, z])[left]
    nearest = away[left].argmin(axis=1)
    lead = (away[left] - reach).min(axis=1)
    named = (away < reach).sum(axis=0)
    found = []
    cells = np.floor((returns[:, :2] - returns[:, :2].min(axis=0)) / CELL_M).astype(np.int64)
    for group in clusters_of(cells):
        enough = group.sum() >= max(FEWEST, SHARE * named[nearest[group]].max())
        reaches = (lead[group] > OUT_M - BODY_M).sum() >= OUT
        if enough and reaches and np.ptp(returns[group, 2]) >= TALL_M:
            found.append((returns[group, :2].min(axis=0) + returns[group, :2].max(axis=0)) / 2)
    places, n = np.array(found).reshape(-1, 2), len(found)
    center = np.column_stack([places, np.full(n, HEIGHT_M / 2)])
    return with_standing(detections, np.full(n, PEDESTRIAN), SCORE, center, np.tile((SIZE_M, SIZE_M, HEIGHT_M), (n, 1)))


def _close(points: NDArray[np.floating]) -> tuple[Floats, Floats, Floats]:
    """Return x, y, z of the returns close ahead that may come from a person's upper body."""
    x, y, z = (np.asarray(points[:, axis], np.float64) for axis in range(3))
    near = (x > AHEAD_M[0]) & (x < AHEAD_M[1]) & (np.abs(y) < ASIDE_M) & (z > LOW_M) & (z < HIGH_M)
    near &= (x > OWN_LENGTH_M) | (np.abs(y) > OWN_WIDTH_M)
    return x[near], y[near], z[near]
