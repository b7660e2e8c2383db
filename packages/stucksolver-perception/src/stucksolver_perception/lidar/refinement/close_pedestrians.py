"""Adds pedestrians close to detected pedestrians.

For two pedestrians half a meter apart, the network often gives one box, on one of them or between both. But both return
rays. So near the vehicle, returns next to a pedestrian, farther from its center than a body reaches, are from another
pedestrian. Above the knees, a walking pedestrian is not wider than a body.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.free_space import footprints, within
from stucksolver_perception.lidar.refinement.clusters import clusters_of, with_stationary
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections, Floats

AHEAD_M = (1.5, 6.0)
"""Distances ahead between which pedestrians are added (m): from the side of the nose, up to where the road is as level
as below the vehicle and a pedestrian has hundreds of returns. Ours."""
LATERAL_M = 3.0
"""Maximum distance from the vehicle's axis (m). Ours."""
EGO_HALF_LENGTH_M, EGO_HALF_WIDTH_M = 2.5, 1.0
"""Half length and half width of the ego (m). Returns from within come from the ego itself. They are smaller than those
of `free_space`, so that a pedestrian who leans on the bumper is found. Ahead of the doors, no part of the body
projects. Ours."""
LOW_M, HIGH_M = 0.7, 2.0
"""Heights above the vehicle's road between which returns count (m): above the legs, which reach farther in a stride."""
BODY_M = 0.4
"""Distance from a pedestrian box's center to its outermost return (m): half a body, and the box's error."""
OUTER_M, MIN_OUTER = 0.5, 4
"""Distance from the detected pedestrian (m), and minimum number of another pedestrian's returns beyond it. An elbow or
a coat has fewer. Ours."""
MAX_DISTANCE_M = 1.0
"""Maximum distance from a detected pedestrian (m). Returns farther away belong to `unexplained_returns`. Ours."""
LAG_S = 0.2
"""Time by which the box of a moving pedestrian may lag (s). Ours."""
MIN_SCORE = 0.2
"""Minimum score of a detection that explains the returns around it. Ours."""
MARGIN_M = 0.4
"""Margin around other boxes within which returns come from their objects (m). Ours."""
MIN_RETURNS, MIN_SHARE = 10, 0.1
"""Minimum number of another pedestrian's returns, and minimum share of those from the detected one. Ours."""
MIN_SPAN_M = 0.3
"""Minimum height that these returns span (m). Ours."""
CELL_M = 0.2
"""Side of a cell for clusters (m). Ours."""
SIZE_M = 0.5
"""Length and width of an added pedestrian (m). Ours."""
HEIGHT_M = 1.7
"""Height of an added pedestrian (m). Ours."""
SCORE = 0.5
"""Score of an added pedestrian, as in `unexplained_returns`. Two of these confirm a track."""

PEDESTRIAN = LABELS.index("pedestrian")
"""Index of the label."""


def add_close_pedestrians(detections: Detections, points: NDArray[np.floating], vehicles: Floats) -> Detections:
    """Return the detections, followed by pedestrians close to a detected one.

    Args:
        detections: Detections in the vehicle frame.
        points: (n, 3 or more): x, y, z (m) of one full turn in the vehicle frame.
        vehicles: (k, 8): tracked vehicles; see `unexplained_returns.with_unexplained`.
    """
    certain = detections.score >= MIN_SCORE
    is_person = certain & (detections.label == PEDESTRIAN)
    centers = detections.center[is_person, :2]
    if not len(centers):
        return detections
    reach = BODY_M + LAG_S * np.hypot(*detections.velocity[is_person].T)
    others = np.column_stack([detections.center, detections.size, detections.yaw])[certain & ~is_person]
    x, y, z = _returns_close_ahead(points)
    distance = np.hypot(x[:, None] - centers[:, 0], y[:, None] - centers[:, 1])
    is_own = (distance < reach).any(axis=1)
    bodies = footprints(np.vstack([others, np.reshape(vehicles, (-1, 8))[:, :7]]))
    unexplained = ~is_own & (distance < MAX_DISTANCE_M).any(axis=1) & ~within(bodies, x, y, MARGIN_M, MARGIN_M)
    if unexplained.sum() < MIN_RETURNS:
        return detections
    returns = np.column_stack([x, y, z])[unexplained]
    nearest = distance[unexplained].argmin(axis=1)
    beyond_m = (distance[unexplained] - reach).min(axis=1)
    num_own = (distance < reach).sum(axis=0)
    centers_found = []
    cells = np.floor((returns[:, :2] - returns[:, :2].min(axis=0)) / CELL_M).astype(np.int64)
    for group in clusters_of(cells):
        has_enough = group.sum() >= max(MIN_RETURNS, MIN_SHARE * num_own[nearest[group]].max())
        is_beyond = (beyond_m[group] > OUTER_M - BODY_M).sum() >= MIN_OUTER
        if has_enough and is_beyond and np.ptp(returns[group, 2]) >= MIN_SPAN_M:
            centers_found.append((returns[group, :2].min(axis=0) + returns[group, :2].max(axis=0)) / 2)
    positions, n = np.array(centers_found).reshape(-1, 2), len(centers_found)
    center = np.column_stack([positions, np.full(n, HEIGHT_M / 2)])
    return with_stationary(
        detections, np.full(n, PEDESTRIAN), SCORE, center, np.tile((SIZE_M, SIZE_M, HEIGHT_M), (n, 1))
    )


def _returns_close_ahead(points: NDArray[np.floating]) -> tuple[Floats, Floats, Floats]:
    """Return x, y, z (m) of the returns close ahead that may come from a person's upper body."""
    x, y, z = (np.asarray(points[:, axis], np.float64) for axis in range(3))
    usable = (x > AHEAD_M[0]) & (x < AHEAD_M[1]) & (np.abs(y) < LATERAL_M) & (z > LOW_M) & (z < HIGH_M)
    usable &= (x > EGO_HALF_LENGTH_M) | (np.abs(y) > EGO_HALF_WIDTH_M)
    return x[usable], y[usable], z[usable]
