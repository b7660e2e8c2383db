"""Joins the LiDAR sweeps of the last half second in the present vehicle frame."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import LidarSweep, PoseEstimate, Singles

RECENT_S = 0.075
"""Maximum age of a sweep that is used completely (s): two of CARLA's at 20 Hz, which make one turn."""
LOW_M, FLAT_M = 0.25, 0.045
"""Height below which points of older sweeps are dropped, if all points of their cell are within the second value (m).
Roads and sidewalks have most points, but show no motion. A bag or a rock makes its cell uneven. Ours."""
CELL_M = 0.64
"""Side of a cell (m): that of the network's grid."""
CELLS = 160
"""Number of cells in each direction; points beyond belong to the outermost cell. Ours."""
MAX_POINTS = 60_000
"""Maximum number of points; beyond it, the older ones are thinned evenly. Ours."""


class SweepBuffer:
    """The last sweeps with their poses. Heights are not changed, because on a slope the vehicle tilts with the road.

    Args:
        horizon_s: Maximum age of a sweep (s).
        max_points: Maximum number of points from `gather`. The points of the last turn are never thinned.
    """

    def __init__(self, horizon_s: float = 0.5, max_points: int = MAX_POINTS) -> None:
        self.horizon_s = horizon_s
        self.max_points = max_points
        self._sweeps: deque[tuple[PoseEstimate, Singles, Singles]] = deque()

    def add(self, sweep: LidarSweep, pose: PoseEstimate) -> None:
        """Add the next sweep.

        Args:
            sweep: Points in the vehicle frame at the time of the sweep.
            pose: The vehicle's pose at that time.

        Raises:
            ValueError: The sweep is older than the last one.
        """
        if self._sweeps and pose.time_s < self._sweeps[-1][0].time_s:
            raise ValueError(
                f"sweep of {pose.time_s:.3f} s after one of {self._sweeps[-1][0].time_s:.3f} s; "
                "sweeps must be in order of time"
            )
        self._sweeps.append((pose, sweep.points, sweep.points[is_uneven(sweep.points)]))
        while self._sweeps[0][0].time_s < pose.time_s - self.horizon_s - 1e-6:
            self._sweeps.popleft()

    def gather(self, pose: PoseEstimate) -> Singles:
        """Return the points of all sweeps in the vehicle frame at `pose`, the newest sweep first.

        Args:
            pose: Pose at the time of the result.

        Returns:
            (n, 5) float32: x, y, z (m), intensity (0 to 1), age (s).
        """
        parts: list[tuple[float, PoseEstimate, Singles]] = []
        for past, all_points, uneven_points in reversed(self._sweeps):
            age_s = pose.time_s - past.time_s
            if age_s <= self.horizon_s - 1e-6:
                parts.append((age_s, past, all_points if age_s <= RECENT_S else uneven_points))
        recent = sum(len(points) for age_s, _, points in parts if age_s <= RECENT_S)
        older = sum(len(points) for age_s, _, points in parts if age_s > RECENT_S)
        step = max(1, math.ceil(older / max(1, self.max_points - recent)))
        parts = [(age_s, past, points if age_s <= RECENT_S else points[::step]) for age_s, past, points in parts]
        gathered = np.empty((sum(len(points) for _, _, points in parts), 5), np.float32)
        start = 0
        for age_s, past, points in parts:
            target = gathered[start : start + len(points)]
            _move(points, past, pose, target)
            target[:, 4] = age_s
            start += len(points)
        return gathered


def is_uneven(points: Singles) -> NDArray[np.bool_]:
    """Return (n,): True for points (n, 4) of a sweep that are not on flat ground; see `LOW_M`."""
    row, column = (np.clip(np.floor(points[:, i] / np.float32(CELL_M)) + CELLS // 2, 0, CELLS - 1) for i in (0, 1))
    cell, z = (row * CELLS + column).astype(np.int64), points[:, 2]
    lowest, highest = np.full(CELLS * CELLS, np.inf, np.float32), np.full(CELLS * CELLS, -np.inf, np.float32)
    np.minimum.at(lowest, cell, z)
    np.maximum.at(highest, cell, z)
    return np.asarray((z > LOW_M) | ((highest - lowest)[cell] > FLAT_M))


def _move(points: Singles, past: PoseEstimate, now: PoseEstimate, into: Singles) -> None:
    """Write points of the vehicle frame at `past` to the first four columns of `into`, in the frame at `now`."""
    turn, cos_now, sin_now = past.yaw_rad - now.yaw_rad, math.cos(now.yaw_rad), math.sin(now.yaw_rad)
    dx, dy = past.x_m - now.x_m, past.y_m - now.y_m
    cos, sin = np.float32(math.cos(turn)), np.float32(math.sin(turn))
    into[:, 0] = cos * points[:, 0] - sin * points[:, 1] + np.float32(cos_now * dx + sin_now * dy)
    into[:, 1] = sin * points[:, 0] + cos * points[:, 1] + np.float32(cos_now * dy - sin_now * dx)
    into[:, 2:4] = points[:, 2:4]
