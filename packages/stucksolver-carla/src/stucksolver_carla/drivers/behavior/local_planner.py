"""Chooses the line that the ego drives, and its place on it: the route, an explicit path, or a return to the route."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stucksolver_carla.drivers.behavior.path import Path, PlanarPose, Projection, flipped, limited_speed
from stucksolver_carla.drivers.behavior.route_line import (
    curve_speed,
    given_path,
    rejoining_length,
    rejoining_path,
    route_path,
    slowed,
)
from stucksolver_carla.drivers.driver_interface import DrivePoint, RoutePoint

ARRIVED_M = 2.0
_REJOIN_BESIDE_M = 0.4
_LOST_M = 25.0


class LocalPlanner:
    """Keeps the progress on the route in every mode, so that points passed beside the lane count too."""

    def __init__(self, lateral_accel: float, deceleration: float) -> None:
        self._lateral_accel = lateral_accel
        self._deceleration = deceleration
        self._route_line: Path | None = None
        self._route_s = self.beside_m = 0.0
        """With `beside_m`: the ego's offset from the route's line (m, right positive)."""
        self._path: Path | None = None
        self._where = Projection(0.0, 0.0, 0.0)
        self.following = False
        self.reversing = False

    @property
    def path(self) -> Path | None:
        """The line being driven; None before any route or path is given."""
        return self._path

    @property
    def where(self) -> Projection:
        """The ego on `path`, as of the last update."""
        return self._where

    @property
    def route_line(self) -> Path | None:
        """The line of the whole route."""
        return self._route_line

    @property
    def route_s(self) -> float:
        """Position of the ego on the route's line (m), beside the lane or not."""
        return self._route_s

    @property
    def arrived(self) -> bool:
        """True within two meters of the route's end."""
        return self._route_line is not None and self._route_s >= self._route_line.length - ARRIVED_M

    def set_route(self, route: Sequence[RoutePoint], pose: PlanarPose, speed: float) -> None:
        """Drive `route` from the ego's position."""
        self.set_line(route_path(route), pose, speed)

    def set_line(self, line: Path, pose: PlanarPose, speed: float) -> None:
        """Drive `line` as the route's, from the ego's position, no faster than its bends allow."""
        bounds = limited_speed(line.s, curve_speed(line.curvature, self._lateral_accel), self._deceleration)
        self._route_line = Path(line.s, line.x, line.y, line.z, line.yaw, line.curvature, bounds)
        self._route_s = self._located(self._route_line, pose, 0.0).s
        self.release(pose, speed)

    def follow(self, points: Sequence[DrivePoint], pose: PlanarPose, z: float, reverse: bool) -> None:
        """Drive `points` at height `z`; points already passed are skipped."""
        line = given_path(points, z)
        bounds = limited_speed(line.s, line.speed, self._deceleration)
        self._path = Path(line.s, line.x, line.y, line.z, line.yaw, line.curvature, bounds)
        self._where = self._path.project(flipped(pose) if reverse else pose)
        self.following = True
        self.reversing = reverse

    def release(self, pose: PlanarPose, speed: float) -> None:
        """Drive the route again from the nearest point of it ahead, returning smoothly from beside it."""
        self.following = self.reversing = False
        path = self._path = self._route_line
        if path is None:
            return
        self._advance_route(pose)
        here = path.project(pose, self._route_s)
        if _REJOIN_BESIDE_M < abs(here.lateral) < _LOST_M:
            self._path = self.way_back(pose, rejoining_length(here.lateral, speed))
            here = self._path.project(pose)
        self._where = here

    def way_back(self, pose: PlanarPose, length: float) -> Path:
        """Return the route from here on, joined from beside it within `length` meters, no faster than the turn
        allows.
        """
        assert self._route_line is not None
        here = self._route_line.project(pose, self._route_s)
        path = rejoining_path(self._route_line, here.s, here.lateral, length)
        return slowed(path, self._lateral_accel, self._deceleration)

    def take(self, path: Path, pose: PlanarPose) -> None:
        """Drive the route by another way back to it."""
        self._path, self._where = path, path.project(pose)

    def update(self, pose: PlanarPose) -> None:
        """Note the ego's position."""
        if self._route_line is not None:
            self._advance_route(pose)
        if self._path is not None:
            seen = flipped(pose) if self.reversing else pose
            self._where = self._located(self._path, seen, self._where.s)

    def _advance_route(self, pose: PlanarPose) -> None:
        assert self._route_line is not None
        here = self._located(self._route_line, pose, self._route_s)
        self._route_s, self.beside_m = here.s, here.lateral

    @staticmethod
    def _located(path: Path, pose: PlanarPose, near_s: float) -> Projection:
        """Search near the last place first, and everywhere if the ego was moved elsewhere."""
        near = path.project(pose, near_s)
        x, y, _ = path.at(np.array([near.s]))
        return near if math.hypot(pose.x - x[0], pose.y - y[0]) < _LOST_M else path.project(pose)
