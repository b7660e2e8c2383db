"""Adds obstacles close ahead for clusters of returns above the ground that are in no box of the network.

A network detects only what it was trained on. It may miss pedestrians who stand close together, for example. But they
return rays, and near the vehicle they return many. So any cluster of returns ahead of the vehicle is an obstacle,
whatever its class. The tracker requires two of these detections, as for any weak detection.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.free_space import EGO_HALF_LENGTH_M, footprints, within
from stucksolver_perception.ground import above_ground
from stucksolver_perception.lidar.refinement.clusters import clusters_of, with_stationary
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections, Floats
from stucksolver_perception.rig import LidarRig

AHEAD_M = 16.0
"""Maximum distance of an obstacle ahead of the reference point (m): that of a stop from 40 km/h. Farther away a small
obstacle has few returns, and the ground's height is less certain."""
LATERAL_M = 3.0
"""Maximum distance of an obstacle from the vehicle's axis (m). Ours."""
LOW_M, HIGH_M = 0.35, 2.0
"""Heights above the ground between which returns count (m). Lower ones may be curbs, and a vehicle passes below higher
ones. Ours."""
MIN_RISE_M = 0.15
"""Minimum height above the ground of a return that is not the road, with the noise of the ground's height (m). Ours."""
CELL_M = 0.3
"""Side of a cell (m). Ours."""
NUM_AROUND = 5
"""Number of cells, in each direction, whose lowest return is the ground. At 16 m, rings of the shipped LiDAR are 1.1 m
apart on the ground. A road with a slope of 20 % rises by less than `LOW_M` in these cells."""
ROAD_M, MAX_DROP_M = 1.0, 0.15
"""Half width of the road ahead (m), and maximum height by which the ground next to it may be lower (m). Without this
limit, the road's edge would be an obstacle above the foot of an embankment. Ours."""
UPRIGHT_M, RAISED_M = 0.25, 0.7
"""Minimum height that an obstacle's returns span, or minimum height of its lowest return, as of a bar (m). A lower flat
surface is a road. Ours."""
UNEVEN_M = 1.0
"""Height by which the ground may be lower than that of `ground.ground_heights`, where the road's slope changes (m).
Ours."""
MIN_RETURNS = 6
"""Minimum number of an obstacle's returns. A pedestrian at 16 m has about 25 with the shipped LiDAR."""
MARGIN_M = 0.4
"""Margin around a box within which returns come from its object (m): mirrors, loads, the error of the box. Ours."""
LAG_S = 0.2
"""Time of a moving object's motion by which its box is longer at either end (s): a turn takes 0.1 s, and the box may
lag by as much."""
LONG_M = 6.0
"""Length from which a vehicle is a bus or truck (m). Ours."""
MOVING_MPS = 1.0
"""Speed from which a vehicle counts as moving (m/s). Ours."""
SHORT_M = 0.7
"""Length by which the box of a moving bus or truck may be too short (m), because the network detects only its rear."""
MIN_SCORE = 0.2
"""Minimum score of a detection that explains the returns around it. Ours."""
SCORE = 0.5
"""Score of an obstacle. Two of these confirm a track (`tracker.CONFIRMED_SCORE`)."""
MAX_PERSON_WIDTH_M, MIN_PERSON_HEIGHT_M = 1.0, 1.1
"""Maximum width and minimum height of an obstacle that counts as a pedestrian, the safest assumption (m). Others are
barriers. Ours."""
MIN_SIZE_M = 0.4
"""Minimum length and width of an obstacle (m). Ours."""

PEDESTRIAN, BARRIER = LABELS.index("pedestrian"), LABELS.index("barrier")


def with_unexplained(detections: Detections, standing: Floats, known: Floats) -> Detections:
    """Return the detections, followed by an obstacle for each cluster of returns close ahead that is in no box.

    Args:
        detections: Detections of the network in the vehicle frame.
        standing: Result of `standing_returns` at the same time.
        known: (k, 8): x, y, z, length, width, height, yaw, speed (m, rad, m/s) of tracked vehicles in the vehicle
            frame. If the network misses one of them, its returns are not another obstacle.
    """
    standing = standing[standing[:, 2] > LOW_M]
    is_certain = detections.score >= MIN_SCORE
    speed = np.hypot(detections.velocity[:, 0], detections.velocity[:, 1])
    detected = np.column_stack([detections.center, detections.size, detections.yaw, speed])[is_certain]
    boxes = np.vstack([detected, np.reshape(known, (-1, 8))])
    widened = footprints(boxes)
    too_short = (boxes[:, 3] > LONG_M) & (boxes[:, 7] > MOVING_MPS)
    widened[:, 3] += LAG_S * boxes[:, 7] + SHORT_M * too_short
    unexplained = standing[~within(widened, standing[:, 0], standing[:, 1], MARGIN_M, MARGIN_M)]
    if len(unexplained) < MIN_RETURNS:
        return detections
    clusters = [unexplained[group] for group in clusters_of(_cells(unexplained[:, 0], unexplained[:, 1]))]
    obstacles = [cluster for cluster in clusters if len(cluster) >= MIN_RETURNS and _is_obstacle(cluster[:, 2])]
    return _with_obstacles(detections, obstacles)


def _is_obstacle(above: Floats) -> bool:
    return float(np.ptp(above)) >= UPRIGHT_M or float(above.min()) >= RAISED_M


def standing_returns(points: NDArray[np.floating], lidar: LidarRig) -> Floats:
    """Return (m, 3): x, y and height above the ground (m) of returns close ahead, from `MIN_RISE_M` to `HIGH_M` high.

    Args:
        points: (n, 3 or more): x, y, z (m) of one full turn in the vehicle frame.
        lidar: Mount of the LiDAR.
    """
    x, y, z = (np.asarray(points[:, axis], np.float64) for axis in range(3))
    is_near = (x > EGO_HALF_LENGTH_M) & (x < AHEAD_M + 4.0) & (np.abs(y) < 2 * AHEAD_M)
    x, y, z = x[is_near], y[is_near], z[is_near]
    dx, dy = x - lidar.mount.x_m, y - lidar.mount.y_m
    # Without returns from the ground below a sign, the lowest return is the sign's, so high returns are removed first.
    low_enough = above_ground(dx, dy, z) < HIGH_M + UNEVEN_M
    in_area = low_enough & (x < AHEAD_M) & (np.abs(y) < LATERAL_M)
    x, y, z = x[in_area], y[in_area], z[in_area]
    above = z - _lowest_around(x, y, z)
    return np.column_stack([x, y, above])[(above > MIN_RISE_M) & (above < HIGH_M)]


def _lowest_around(x: Floats, y: Floats, z: Floats) -> Floats:
    """Return (m,): the height of the lowest return in the cells around each return, limited by the road ahead (m)."""
    from scipy import ndimage  # type: ignore[import-untyped]

    cells = _cells(x, y)
    lowest = np.full((round((AHEAD_M - EGO_HALF_LENGTH_M) / CELL_M) + 1, round(2 * LATERAL_M / CELL_M) + 1), np.inf)
    np.minimum.at(lowest, (cells[:, 0], cells[:, 1]), z)
    lowest_around = ndimage.minimum_filter(lowest, NUM_AROUND, mode="nearest")
    in_road = np.abs((np.arange(lowest.shape[1]) + 0.5) * CELL_M - LATERAL_M) < ROAD_M
    road = ndimage.minimum_filter(lowest, (NUM_AROUND, 1), mode="nearest")[:, in_road].min(axis=1)
    floor = np.where(np.isfinite(road), road - MAX_DROP_M, -np.inf)
    return np.asarray(np.maximum(lowest_around, floor[:, None])[cells[:, 0], cells[:, 1]])


def _cells(x: Floats, y: Floats) -> NDArray[np.int64]:
    """Return (m, 2): the cell of each return."""
    return np.floor(np.column_stack([x - EGO_HALF_LENGTH_M, y + LATERAL_M]) / CELL_M).astype(np.int64)


def _with_obstacles(detections: Detections, clusters: list[Floats]) -> Detections:
    if not clusters:
        return detections
    low, high = (np.array([limit(cluster, axis=0) for cluster in clusters]) for limit in (np.min, np.max))
    top = high[:, 2]
    size = np.column_stack([np.maximum(high[:, :2] - low[:, :2], MIN_SIZE_M), top])
    is_person = (size[:, :2].max(axis=1) <= MAX_PERSON_WIDTH_M) & (top >= MIN_PERSON_HEIGHT_M)
    # Only the near side of an object returns rays, so the center of the returns is the best estimate.
    center = np.column_stack([(low[:, :2] + high[:, :2]) / 2, top / 2])
    return with_stationary(detections, np.where(is_person, PEDESTRIAN, BARRIER), SCORE, center, size)
