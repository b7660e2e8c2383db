"""Chooses the line that the ego drives, and tracks its position: the route, a set path, or a return to the route."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stucksolver_carla.drivers.behavior.path import Path, PlanarPose, Projection, flipped, limited_speed
from stucksolver_carla.drivers.behavior.route_line import (
    curve_speed,
    path_from_points,
    rejoining_length,
    rejoining_path,
    route_path,
    speed_limited_path,
)
from stucksolver_carla.drivers.driver_interface import DrivePoint, RoutePoint

ARRIVED_M = 2.0
"""Distance to the route's end at which the ego has arrived (m). Ours."""
_REJOIN_OFFSET_M = 0.4
"""Offset from the route above which the ego returns to it on a smooth path (m). Ours."""
_LOST_M = 25.0
"""Distance from the line from which the ego was moved elsewhere, and is searched on the whole line (m). Ours."""


class LocalPlanner:
    """The line and the position on it. The progress on the route is updated in every mode, also next to the lane."""

    def __init__(self, lateral_accel: float, deceleration: float) -> None:
        self._lateral_accel = lateral_accel
        self._deceleration = deceleration
        self._route_line: Path | None = None
        self._route_s = self.beside_m = 0.0
        """`beside_m` is the ego's offset from the route's line (m, right positive)."""
        self._path: Path | None = None
        self._where = Projection(0.0, 0.0, 0.0)
        self.following = False
        self.reversing = False

    @property
    def path(self) -> Path | None:
        """The driven line; None before any route or path is set."""
        return self._path

    @property
    def where(self) -> Projection:
        """Projection of the ego on `path` at the last update."""
        return self._where

    @property
    def route_line(self) -> Path | None:
        """The line of the whole route."""
        return self._route_line

    @property
    def route_s(self) -> float:
        """Arc length of the ego on the route's line (m), also next to the lane."""
        return self._route_s

    @property
    def arrived(self) -> bool:
        """True if the ego is within two meters of the route's end."""
        return self._route_line is not None and self._route_s >= self._route_line.length - ARRIVED_M

    def set_route(self, route: Sequence[RoutePoint], pose: PlanarPose, speed: float) -> None:
        """Drive `route` from the ego's position."""
        self.set_line(route_path(route), pose, speed)

    def set_line(self, line: Path, pose: PlanarPose, speed: float) -> None:
        """Drive `line` as the route's line, from the ego's position, at the speed that its bends allow."""
        bounds = limited_speed(line.s, curve_speed(line.curvature, self._lateral_accel), self._deceleration)
        self._route_line = Path(line.s, line.x, line.y, line.z, line.yaw, line.curvature, bounds)
        self._route_s = self._located(self._route_line, pose, 0.0).s
        self.release(pose, speed)

    def follow(self, points: Sequence[DrivePoint], pose: PlanarPose, z: float, reverse: bool) -> None:
        """Drive `points` at height `z`. Points behind the ego are skipped."""
        line = path_from_points(points, z)
        bounds = limited_speed(line.s, line.speed, self._deceleration)
        self._path = Path(line.s, line.x, line.y, line.z, line.yaw, line.curvature, bounds)
        self._where = self._path.project(flipped(pose) if reverse else pose)
        self.following = True
        self.reversing = reverse

    def release(self, pose: PlanarPose, speed: float) -> None:
        """Drive the route again from its nearest point ahead, on a smooth path if the ego is next to it."""
        self.following = self.reversing = False
        path = self._path = self._route_line
        if path is None:
            return
        self._advance_route(pose)
        projection = path.project(pose, self._route_s)
        if _REJOIN_OFFSET_M < abs(projection.lateral) < _LOST_M:
            self._path = self.way_back(pose, rejoining_length(projection.lateral, speed))
            projection = self._path.project(pose)
        self._where = projection

    def way_back(self, pose: PlanarPose, length: float) -> Path:
        """Return the rest of the route, joined within `length` meters, at the speed that the bends allow."""
        assert self._route_line is not None
        projection = self._route_line.project(pose, self._route_s)
        path = rejoining_path(self._route_line, projection.s, projection.lateral, length)
        return speed_limited_path(path, self._lateral_accel, self._deceleration)

    def take(self, path: Path, pose: PlanarPose) -> None:
        """Drive the route on another path back to it."""
        self._path, self._where = path, path.project(pose)

    def update(self, pose: PlanarPose) -> None:
        """Update the ego's position."""
        if self._route_line is not None:
            self._advance_route(pose)
        if self._path is not None:
            driving_pose = flipped(pose) if self.reversing else pose
            self._where = self._located(self._path, driving_pose, self._where.s)

    def _advance_route(self, pose: PlanarPose) -> None:
        assert self._route_line is not None
        projection = self._located(self._route_line, pose, self._route_s)
        self._route_s, self.beside_m = projection.s, projection.lateral

    @staticmethod
    def _located(path: Path, pose: PlanarPose, near_s: float) -> Projection:
        """Return the projection near the last position, or on the whole line if the ego was moved elsewhere."""
        near = path.project(pose, near_s)
        x, y, _ = path.at(np.array([near.s]))
        return near if math.hypot(pose.x - x[0], pose.y - y[0]) < _LOST_M else path.project(pose)
