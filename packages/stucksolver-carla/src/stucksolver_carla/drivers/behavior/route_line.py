"""From lane-center points to the driven line: lane changes and returns to the route made smooth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stucksolver.scene.polyline import arc_lengths
from stucksolver_carla.drivers.behavior.path import Array, Path, limited_speed, make_path
from stucksolver_carla.drivers.driver_interface import DrivePoint, RoutePoint

LANE_CHANGE_M = 40.0
"""Length of a lane change of the route, unless a junction or the route's end comes first."""
_MIN_LANE_CHANGE_M = 10.0
LEAST_STEP_M = 1.5
_REJOIN_S = 3.0
_REJOIN_PER_M = 4.0
_MIN_REJOIN_M = 8.0
_UNBOUNDED_MPS = 100.0


def smooth_step(u: Array) -> Array:
    """0 to 1 over u in [0, 1] with zero first and second derivative at both ends."""
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u * u * u * (10.0 + u * (6.0 * u - 15.0)))


def curve_speed(curvature: Array, lateral_accel: float) -> Array:
    """Return the speed (m/s) at which a bend of `curvature` (1/m) needs `lateral_accel` (m/s²)."""
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
    heading = np.radians([t.rotation.yaw for t in transforms])
    shift_x, shift_y = np.zeros_like(x), np.zeros_like(y)
    for k in range(1, len(route)):
        aside = (y[k - 1] - y[k]) * math.cos(heading[k]) - (x[k - 1] - x[k]) * math.sin(heading[k])
        if route[k].command.startswith("change") and abs(aside) > LEAST_STEP_M:
            # The line stays in the old lane at this point and moves to the new one from here.
            along = arc_lengths(np.column_stack([x[k:], y[k:]]))
            left = aside * (1.0 - smooth_step(along / change_length(route, k)))
            shift_x[k:] -= left * np.sin(heading[k:])
            shift_y[k:] += left * np.cos(heading[k:])
    return make_path(x + shift_x, y + shift_y, np.full(len(x), _UNBOUNDED_MPS), z)


def change_length(route: Sequence[RoutePoint], k: int) -> float:
    """Return the meters available for the lane change at point `k`; points lie about a meter apart."""
    end = next((j for j in range(k, len(route)) if route[j].waypoint.is_junction), len(route))
    return min(max(end - k - 1.0, _MIN_LANE_CHANGE_M), LANE_CHANGE_M)


def rejoining_length(lateral: float, speed: float) -> float:
    """Return the meters over which the ego returns from `lateral` meters beside its route at `speed` (m/s)."""
    return max(_MIN_REJOIN_M, _REJOIN_PER_M * abs(lateral), _REJOIN_S * speed)


def rejoining_path(path: Path, s: float, lateral: float, length: float) -> Path:
    """The rest of `path` from arc length `s`, reached within `length` meters from `lateral` meters beside it."""
    rest = path.s >= min(s, path.length - 1.0)
    offset = lateral * (1.0 - smooth_step((path.s[rest] - s) / length))
    return beside(path, rest, offset, path.speed[rest])


def beside(path: Path, where: NDArray[np.bool_], offset: Array, speed: Array) -> Path:
    """The samples `where` of `path`, moved aside by `offset` (m, right positive), with bounds on `speed` (m/s)."""
    x = path.x[where] - offset * np.sin(path.yaw[where])
    y = path.y[where] + offset * np.cos(path.yaw[where])
    return make_path(x, y, speed, path.z[where])


def slowed(path: Path, lateral_accel: float, deceleration: float) -> Path:
    """Return the path, no faster than its bends allow, each slower place reached with that deceleration (both m/s²)."""
    bounds = np.minimum(path.speed, curve_speed(path.curvature, lateral_accel))
    return replace(path, speed=limited_speed(path.s, bounds, deceleration))


def given_path(points: Sequence[DrivePoint], z: float) -> Path:
    """Return the line through explicit points at height `z`.

    Raises:
        ValueError: It cannot be driven.
    """
    if len(points) < 2:
        raise ValueError(f"a path to follow needs at least 2 points, got {len(points)}")
    array = np.array(points, dtype=np.float64)
    if not np.all(np.isfinite(array)):
        raise ValueError("a path to follow has a coordinate or speed that is not finite; drop or repair that point")
    if np.any(array[:-1, 2] <= 0.0):
        first = int(np.argmax(array[:-1, 2] <= 0.0))
        raise ValueError(f"point {first} of the path bounds the speed to 0: the car would never pass it; use hold()")
    return make_path(array[:, 0], array[:, 1], array[:, 2], np.full(len(points), z))
