"""The LiDAR sweeps of the last half second, moved into the present vehicle frame."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import LidarSweep, PoseEstimate, Singles

RECENT_S = 0.075
"""Sweeps up to this age are kept completely: two of CARLA's at 20 Hz, which make one turn."""
LOW_M, FLAT_M = 0.25, 0.045
"""In older sweeps, points lower than the first value are dropped if all points of a cell are within the second:
the road and pavements say nothing about motion and are most points. A bag or a rock among them makes its cell
uneven.
"""
CELL_M = 0.64
CELLS = 160
"""In each direction; anything beyond counts to the outermost cell."""
MOST_POINTS = 60_000
"""Older points are thinned evenly beyond this number."""


class SweepBuffer:
    """Keeps sweeps with their poses. Heights are not changed: on a slope the road tilts with us.

    Args:
        horizon_s: Older sweeps are forgotten (s).
        most_points: Largest number of points from `gather`; those of the last turn are never thinned.
    """

    def __init__(self, horizon_s: float = 0.5, most_points: int = MOST_POINTS) -> None:
        self.horizon_s = horizon_s
        self.most_points = most_points
        self._kept: deque[tuple[PoseEstimate, Singles, Singles]] = deque()

    def add(self, sweep: LidarSweep, pose: PoseEstimate) -> None:
        """Add the next sweep.

        Args:
            sweep: In the vehicle frame at its time.
            pose: The vehicle's pose at the sweep's time.

        Raises:
            ValueError: The sweep is older than the last one.
        """
        if self._kept and pose.time_s < self._kept[-1][0].time_s:
            raise ValueError(f"a sweep of {pose.time_s:.3f} s came after one of {self._kept[-1][0].time_s:.3f} s")
        self._kept.append((pose, sweep.points, sweep.points[uneven(sweep.points)]))
        while self._kept[0][0].time_s < pose.time_s - self.horizon_s - 1e-6:
            self._kept.popleft()

    def gather(self, pose: PoseEstimate) -> Singles:
        """Return everything kept, as seen from the vehicle at `pose`.

        Args:
            pose: Pose at the moment for which the points are wanted.

        Returns:
            (n, 5) float32: x, y, z (m), intensity (0 to 1), age (s); the newest sweep first.
        """
        parts: list[tuple[float, PoseEstimate, Singles]] = []
        for past, whole, rough in reversed(self._kept):
            age_s = pose.time_s - past.time_s
            if age_s <= self.horizon_s - 1e-6:
                parts.append((age_s, past, whole if age_s <= RECENT_S else rough))
        recent = sum(len(points) for age_s, _, points in parts if age_s <= RECENT_S)
        older = sum(len(points) for age_s, _, points in parts if age_s > RECENT_S)
        step = max(1, math.ceil(older / max(1, self.most_points - recent)))
        parts = [(age_s, past, points if age_s <= RECENT_S else points[::step]) for age_s, past, points in parts]
        gathered = np.empty((sum(len(points) for _, _, points in parts), 5), np.float32)
        at = 0
        for age_s, past, points in parts:
            place = gathered[at : at + len(points)]
            _move(points, past, pose, place)
            place[:, 4] = age_s
            at += len(points)
        return gathered


def uneven(points: Singles) -> NDArray[np.bool_]:
    """Return which points (n, 4) of a sweep are kept longer: those that are not on flat ground (see `LOW_M`)."""
    row, column = (np.clip(np.floor(points[:, i] / np.float32(CELL_M)) + CELLS // 2, 0, CELLS - 1) for i in (0, 1))
    cell, z = (row * CELLS + column).astype(np.int64), points[:, 2]
    lowest, highest = np.full(CELLS * CELLS, np.inf, np.float32), np.full(CELLS * CELLS, -np.inf, np.float32)
    np.minimum.at(lowest, cell, z)
    np.maximum.at(highest, cell, z)
    return np.asarray((z > LOW_M) | ((highest - lowest)[cell] > FLAT_M))


def _move(points: Singles, past: PoseEstimate, now: PoseEstimate, into: Singles) -> None:
    """Write `points`, seen from `past`, as seen from `now` into the first four columns of `into`."""
    turn, cos_now, sin_now = past.yaw_rad - now.yaw_rad, math.cos(now.yaw_rad), math.sin(now.yaw_rad)
    dx, dy = past.x_m - now.x_m, past.y_m - now.y_m
    cos, sin = np.float32(math.cos(turn)), np.float32(math.sin(turn))
    into[:, 0] = cos * points[:, 0] - sin * points[:, 1] + np.float32(cos_now * dx + sin_now * dy)
    into[:, 1] = sin * points[:, 0] + cos * points[:, 1] + np.float32(cos_now * dy - sin_now * dx)
    into[:, 2:4] = points[:, 2:4]
