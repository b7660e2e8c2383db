"""Obstacles close ahead that the detector did not name: returns that stand on the ground and in none of its boxes.

A network finds what it was trained on. People who stand close together, say, may be nothing at all to it. But rays came
back from them, and near the vehicle there are many of these. So what stands up in front of the vehicle counts as an
obstacle, whatever it is; the tracker asks for it in two looks, as for any weak detection.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.free_space import EGO_HALF_LENGTH_M, footprints, within
from stucksolver_perception.ground import above_ground
from stucksolver_perception.lidar.refinement.clusters import clusters_of, with_standing
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections, Floats
from stucksolver_perception.rig import LidarRig

AHEAD_M = 16.0
"""Obstacles are looked for up to this distance ahead of the reference point: a stop from 40 km/h. Further away a small
obstacle has few returns, and the ground's height is less certain."""
ASIDE_M = 3.0
"""To either side of the vehicle's axis."""
LOW_M, HIGH_M = 0.35, 2.0
"""Height above ground: lower returns may be curbs, and what begins higher lets the vehicle pass below."""
RAISES_M = 0.15
"""A lower return is the road, with the noise of the ground's height."""
CELL_M = 0.3
AROUND = 5
"""The ground is the lowest return in this many cells by as many. At 16 m, rings of the shipped LiDAR are 1.1 m apart on
the ground. A road that rises by 20 % rises by less than `LOW_M` within them.
"""
ROAD_M, LOWER_M = 1.0, 0.15
"""The road in front is the strip this wide to either side of the vehicle's axis. Beside it the ground may be lower by
this much; from an embankment's foot, the road's edge would stand up.
"""
UPRIGHT_M, RAISED_M = 0.25, 0.7
"""An obstacle is this tall, or its lowest return is this high: a bar. A lower flat surface is a road."""
UNEVEN_M = 1.0
"""How much lower than `ground.ground_heights` says the ground may be here, where the road's slope changes."""
FEWEST = 6
"""Returns of an obstacle: a person at 16 m has about 25 of the shipped LiDAR."""
MARGIN_M = 0.4
"""Boxes are this much smaller than what they stand for: mirrors, loads, the error of the box."""
SMEARED_S = 0.2
"""A turn takes 0.1 s, and the box of what moves may lag by as much: returns from its ends lie outside of it."""
LONG_M = 6.0
"""A vehicle that is longer is a bus or truck."""
DRIVES_MPS = 1.0
"""A vehicle that is faster drives."""
SHORT_M = 0.7
"""The box of a bus or truck that drives may end this much too early: the network sees its rear only."""
EXPLAINS = 0.2
"""Score from which a detection explains the returns around it."""
SCORE = 0.5
"""Two of these confirm a track (`tracker.CONFIRMING_SCORE`)."""
PERSON_WIDE_M, PERSON_TALL_M = 1.0, 1.1
"""An obstacle no wider and no lower counts as a person: the most careful reading of it. Others are barriers."""
LEAST_M = 0.4

PEDESTRIAN, BARRIER = LABELS.index("pedestrian"), LABELS.index("barrier")


def with_unexplained(detections: Detections, standing: Floats, known: Floats) -> Detections:
    """Return the detections, and after them an obstacle for each cluster of returns close ahead that is in no box.

    Args:
        detections: Of the network, in the vehicle frame.
        standing: What `standing_returns` found, at the same time.
        known: (k, 8): x, y, z, length, width, height, yaw, speed (m, rad, m/s) of vehicles that are tracked, in the
            vehicle frame. If the network misses one of them for a look, its returns are not another obstacle.
    """
    standing = standing[standing[:, 2] > LOW_M]
    sure = detections.score >= EXPLAINS
    speed = np.hypot(detections.velocity[:, 0], detections.velocity[:, 1])
    named = np.column_stack([detections.center, detections.size, detections.yaw, speed])[sure]
    boxes = np.vstack([named, np.reshape(known, (-1, 8))])
    bodies = footprints(boxes)
    too_short = (boxes[:, 3] > LONG_M) & (boxes[:, 7] > DRIVES_MPS)
    bodies[:, 3] += SMEARED_S * boxes[:, 7] + SHORT_M * too_short
    left = standing[~within(bodies, standing[:, 0], standing[:, 1], MARGIN_M, MARGIN_M)]
    if len(left) < FEWEST:
        return detections
    found = [left[group] for group in clusters_of(_cells(left[:, 0], left[:, 1]))]
    return _joined(detections, [item for item in found if len(item) >= FEWEST and _stands(item[:, 2])])


def _stands(above: Floats) -> bool:
    return float(np.ptp(above)) >= UPRIGHT_M or float(above.min()) >= RAISED_M


def standing_returns(points: NDArray[np.floating], lidar: LidarRig) -> Floats:
    """(m, 3): x, y and height above ground (m) of the returns that stand up close ahead, by at least `RAISES_M`.

    Args:
        points: (n, 3 or more): x, y, z (m) of one full turn in the vehicle frame.
        lidar: Where the LiDAR is mounted.
    """
    x, y, z = (np.asarray(points[:, axis], np.float64) for axis in range(3))
    near = (x > EGO_HALF_LENGTH_M) & (x < AHEAD_M + 4.0) & (np.abs(y) < 2 * AHEAD_M)
    x, y, z = x[near], y[near], z[near]
    dx, dy = x - lidar.mount.x_m, y - lidar.mount.y_m
    # Where nothing of the ground is seen below a sign, the lowest return is the sign's own.
    low_enough = above_ground(dx, dy, z) < HIGH_M + UNEVEN_M
    within = low_enough & (x < AHEAD_M) & (np.abs(y) < ASIDE_M)
    x, y, z = x[within], y[within], z[within]
    above = z - _lowest_around(x, y, z)
    return np.column_stack([x, y, above])[(above > RAISES_M) & (above < HIGH_M)]


def _lowest_around(x: Floats, y: Floats, z: Floats) -> Floats:
    """(m,): height of the lowest return in the cells around each, but not much lower than the road in front."""
    from scipy import ndimage  # type: ignore[import-untyped]

    cells = _cells(x, y)
    lowest = np.full((round((AHEAD_M - EGO_HALF_LENGTH_M) / CELL_M) + 1, round(2 * ASIDE_M / CELL_M) + 1), np.inf)
    np.minimum.at(lowest, (cells[:, 0], cells[:, 1]), z)
    around = ndimage.minimum_filter(lowest, AROUND, mode="nearest")
    middle = np.abs((np.arange(lowest.shape[1]) + 0.5) * CELL_M - ASIDE_M) < ROAD_M
    road = ndimage.minimum_filter(lowest, (AROUND, 1), mode="nearest")[:, middle].min(axis=1)
    floor = np.where(np.isfinite(road), road - LOWER_M, -np.inf)
    return np.asarray(np.maximum(around, floor[:, None])[cells[:, 0], cells[:, 1]])


def _cells(x: Floats, y: Floats) -> NDArray[np.int64]:
    """(m, 2): cell of each place."""
    return np.floor(np.column_stack([x - EGO_HALF_LENGTH_M, y + ASIDE_M]) / CELL_M).astype(np.int64)


def _joined(detections: Detections, found: list[Floats]) -> Detections:
    if not found:
        return detections
    low, high = (np.array([f(item, axis=0) for item in found]) for f in (np.min, np.max))
    top = high[:, 2]
    size = np.column_stack([np.maximum(high[:, :2] - low[:, :2], LEAST_M), top])
    person = (size[:, :2].max(axis=1) <= PERSON_WIDE_M) & (top >= PERSON_TALL_M)
    # Only the near side of a body returns rays, so its middle is not known better than that.
    center = np.column_stack([(low[:, :2] + high[:, :2]) / 2, top / 2])
    return with_standing(detections, np.where(person, PEDESTRIAN, BARRIER), SCORE, center, size)
