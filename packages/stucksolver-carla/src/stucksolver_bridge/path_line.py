"""Holds a path of points with speed bounds in CARLA's left-handed world frame (m, x east, y south), without numpy."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import Sequence

MIN_STEP_M = 1e-3
"""Minimum distance between two points (m); nearer ones are dropped, because their direction is undefined. Ours."""


class PathLine:
    """A path of at least two points (x, y, speed bound in m/s) at different positions.

    Raises:
        ValueError: The path has fewer than two.
    """

    def __init__(self, points: Sequence[Sequence[float]]) -> None:
        self.x = [float(points[0][0])] if points else []
        self.y = [float(points[0][1])] if points else []
        self.speed = [float(points[0][2])] if points else []
        self.s = [0.0]
        for x, y, speed in points[1:]:
            step = math.hypot(x - self.x[-1], y - self.y[-1])
            if step < MIN_STEP_M:
                continue
            self.x.append(float(x))
            self.y.append(float(y))
            self.speed.append(float(speed))
            self.s.append(self.s[-1] + step)
        if len(self.s) < 2:
            raise ValueError("a path must have at least two points at different positions")

    @property
    def length_m(self) -> float:
        """Length of the path (m)."""
        return self.s[-1]

    def at(self, s: float) -> tuple[float, float, float]:
        """Return (x, y, heading in radians) at an arc length. Beyond either end the path continues straight."""
        i = min(max(bisect_right(self.s, s) - 1, 0), len(self.s) - 2)
        length = self.s[i + 1] - self.s[i]
        ux, uy = (self.x[i + 1] - self.x[i]) / length, (self.y[i + 1] - self.y[i]) / length
        ahead = s - self.s[i]
        return self.x[i] + ux * ahead, self.y[i] + uy * ahead, math.atan2(uy, ux)

    def lateral_m(self, x: float, y: float, s: float) -> float:
        """Return the lateral offset of the point (x, y), which projects to `s` (m; positive to the right)."""
        on_x, on_y, yaw = self.at(s)
        return (y - on_y) * math.cos(yaw) - (x - on_x) * math.sin(yaw)

    def bound_at(self, s: float, braking_mps2: float) -> float:
        """Return the highest speed from which braking meets every speed bound ahead, up to the path's end (m/s)."""
        i = min(max(bisect_right(self.s, s) - 1, 0), len(self.s) - 2)
        share = (s - self.s[i]) / (self.s[i + 1] - self.s[i])
        share = min(max(share, 0.0), 1.0)
        here = self.speed[i] + share * (self.speed[i + 1] - self.speed[i])
        ahead = (
            math.sqrt(self.speed[k] ** 2 + 2.0 * braking_mps2 * max(self.s[k] - s, 0.0))
            for k in range(i + 1, len(self.s))
        )
        return min(here, *ahead)

    def project(self, x: float, y: float, near_s: float, reach_m: float = 8.0) -> float:
        """Return the arc length of the nearest point of the path within `reach_m` of `near_s`."""
        best_m, best_s = math.inf, near_s
        for i in range(len(self.s) - 1):
            if self.s[i + 1] < near_s - reach_m or self.s[i] > near_s + reach_m:
                continue
            length = self.s[i + 1] - self.s[i]
            ux, uy = (self.x[i + 1] - self.x[i]) / length, (self.y[i + 1] - self.y[i]) / length
            along = (x - self.x[i]) * ux + (y - self.y[i]) * uy
            # A point may project beyond the path's end. The arc length then includes the distance past the end.
            last = i == len(self.s) - 2
            along = max(along, 0.0) if last else min(max(along, 0.0), length)
            distance_m = math.hypot(x - self.x[i] - ux * along, y - self.y[i] - uy * along)
            if distance_m < best_m:
                best_m, best_s = distance_m, self.s[i] + along
        return best_s
