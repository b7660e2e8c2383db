"""From lane-centre points to the line really driven: lane changes and returns to the route made smooth."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stucksolver.stacks.driver.interface import DrivePoint, RoutePoint
from stucksolver.stacks.driver.path import Array, Path, make_path

LANE_CHANGE_M = 22.0
"""Length over which a lane change of the route is driven."""
_LANE_STEP_M = 1.5
_REJOIN_S = 3.0
_REJOIN_PER_M = 4.0
_MIN_REJOIN_M = 8.0
_UNBOUNDED_MPS = 100.0


def smooth_step(u: Array) -> Array:
    """0 to 1 over u in [0, 1] with zero first and second derivative at both ends."""
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u * u * u * (10.0 + u * (6.0 * u - 15.0)))


def curve_speed(curvature: Array, lateral_accel: float) -> Array:
    """Speed (m/s) at which a bend of `curvature` (1/m) asks for `lateral_accel` (m/s²)."""
    return np.asarray(np.sqrt(lateral_accel / np.maximum(np.abs(curvature), lateral_accel / _UNBOUNDED_MPS**2)))


def route_path(route: Sequence[RoutePoint]) -> Path:
    """The line along a route, without any bound on speed."""
    transforms = [point.waypoint.transform for point in route]
    x = np.array([t.location.x for t in transforms])
    y = np.array([t.location.y for t in transforms])
    z = np.array([t.location.z for t in transforms])
    if len(route) == 1:
        yaw = math.radians(transforms[0].rotation.yaw)
        x, y, z = np.append(x, x[0] + math.cos(yaw)), np.append(y, y[0] + math.sin(yaw)), np.append(z, z[0])
        return make_path(x, y, np.full(2, _UNBOUNDED_MPS), z)
    shift_x, shift_y = np.zeros_like(x), np.zeros_like(y)
    for k in _jumps(route, x, y):
        _add_blend(k, math.radians(transforms[k].rotation.yaw), (x, y), (shift_x, shift_y))
    return make_path(x + shift_x, y + shift_y, np.full(len(x), _UNBOUNDED_MPS), z)


def rejoining_path(path: Path, s: float, lateral: float, speed: float) -> Path:
    """The rest of `path` from arc length `s`, reached smoothly from `lateral` metres beside it at `speed`."""
    rest = path.s >= min(s, path.length - 1.0)
    length = max(_MIN_REJOIN_M, _REJOIN_PER_M * abs(lateral), _REJOIN_S * speed)
    offset = lateral * (1.0 - smooth_step((path.s[rest] - s) / length))
    x = path.x[rest] - offset * np.sin(path.yaw[rest])
    y = path.y[rest] + offset * np.cos(path.yaw[rest])
    return make_path(x, y, path.speed[rest], path.z[rest])


def given_path(points: Sequence[DrivePoint], z: float) -> Path:
    """The line through explicit points at height `z`. Raises `ValueError` where it cannot be driven."""
    if len(points) < 2:
        raise ValueError(f"a path to follow needs at least 2 points, got {len(points)}")
    array = np.array(points, dtype=np.float64)
    if not np.all(np.isfinite(array)):
        raise ValueError("a path to follow has a coordinate or speed that is not finite; drop or repair that point")
    if np.any(array[:-1, 2] <= 0.0):
        first = int(np.argmax(array[:-1, 2] <= 0.0))
        raise ValueError(f"point {first} of the path bounds the speed to 0: the car would never pass it; use hold()")
    return make_path(array[:, 0], array[:, 1], array[:, 2], np.full(len(points), z))


def _jumps(route: Sequence[RoutePoint], x: Array, y: Array) -> list[int]:
    """Indices of the first points in a new lane."""
    found = []
    for k in range(1, len(route)):
        if route[k].command.startswith("change"):
            yaw = math.radians(route[k].waypoint.transform.rotation.yaw)
            lateral = (y[k - 1] - y[k]) * math.cos(yaw) - (x[k - 1] - x[k]) * math.sin(yaw)
            if abs(lateral) > _LANE_STEP_M:
                found.append(k)
    return found


def _add_blend(k: int, yaw: float, xy: tuple[Array, Array], shift: tuple[Array, Array]) -> None:
    """Keep the line in the old lane at point `k` and lead it over to the new one."""
    x, y = xy
    lateral = (y[k - 1] - y[k]) * math.cos(yaw) - (x[k - 1] - x[k]) * math.sin(yaw)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x[k:]), np.diff(y[k:])))])
    left = lateral * (1.0 - smooth_step(along / min(LANE_CHANGE_M, max(float(along[-1]), 1.0))))
    heading = np.arctan2(np.gradient(y[k:]), np.gradient(x[k:])) if len(along) > 1 else np.array([yaw])
    shift[0][k:] -= left * np.sin(heading)
    shift[1][k:] += left * np.cos(heading)
