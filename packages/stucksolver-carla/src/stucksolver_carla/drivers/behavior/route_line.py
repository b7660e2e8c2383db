"""Builds the driven line from lane-center points, with smooth lane changes and returns to the route."""

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
"""Length of a lane change of the route, unless a junction or the route's end comes first (m). Ours."""
_MIN_LANE_CHANGE_M = 10.0
"""Minimum length of a lane change of the route (m). Ours."""
MIN_LANE_STEP_M = 1.5
"""Minimum lateral distance between the lanes of a lane change (m). Ours."""
_REJOIN_S = 3.0
"""Minimum duration of a return to the route (s). Ours."""
_REJOIN_PER_M = 4.0
"""Minimum length of a return to the route per meter of offset. Ours."""
_MIN_REJOIN_M = 8.0
"""Minimum length of a return to the route (m). Ours."""
_UNBOUNDED_MPS = 100.0
"""Speed bound that has no effect (m/s)."""


def smooth_step(u: Array) -> Array:
    """Return a step from 0 to 1 over u in [0, 1], with zero first and second derivative at both ends."""
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u * u * u * (10.0 + u * (6.0 * u - 15.0)))


def curve_speed(curvature: Array, lateral_accel: float) -> Array:
    """Return the speed (m/s) at which a bend of `curvature` (1/m) requires `lateral_accel` (m/s²)."""
    return np.asarray(np.sqrt(lateral_accel / np.maximum(np.abs(curvature), lateral_accel / _UNBOUNDED_MPS**2)))


def route_path(route: Sequence[RoutePoint]) -> Path:
    """Return the line along a route, without speed bounds."""
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
        lateral_m = (y[k - 1] - y[k]) * math.cos(heading[k]) - (x[k - 1] - x[k]) * math.sin(heading[k])
        if route[k].command.startswith("change") and abs(lateral_m) > MIN_LANE_STEP_M:
            # At this point the line is still in the old lane. It moves to the new lane after it.
            along = arc_lengths(np.column_stack([x[k:], y[k:]]))
            remaining_m = lateral_m * (1.0 - smooth_step(along / change_length(route, k)))
            shift_x[k:] -= remaining_m * np.sin(heading[k:])
            shift_y[k:] += remaining_m * np.cos(heading[k:])
    return make_path(x + shift_x, y + shift_y, np.full(len(x), _UNBOUNDED_MPS), z)


def change_length(route: Sequence[RoutePoint], k: int) -> float:
    """Return the length for the lane change at point `k` (m). The points are about one meter apart."""
    end = next((j for j in range(k, len(route)) if route[j].waypoint.is_junction), len(route))
    return min(max(end - k - 1.0, _MIN_LANE_CHANGE_M), LANE_CHANGE_M)


def rejoining_length(lateral: float, speed: float) -> float:
    """Return the length of a return from an offset of `lateral` (m) to the route at `speed` (m/s)."""
    return max(_MIN_REJOIN_M, _REJOIN_PER_M * abs(lateral), _REJOIN_S * speed)


def rejoining_path(path: Path, s: float, lateral: float, length: float) -> Path:
    """Return the rest of `path` from arc length `s`, joined within `length` from an offset of `lateral` (all in m)."""
    rest = path.s >= min(s, path.length - 1.0)
    offset = lateral * (1.0 - smooth_step((path.s[rest] - s) / length))
    return offset_path(path, rest, offset, path.speed[rest])


def offset_path(path: Path, selected: NDArray[np.bool_], offset: Array, speed: Array) -> Path:
    """Return the selected samples of `path`, shifted by `offset` (m, right positive), with bounds `speed` (m/s)."""
    x = path.x[selected] - offset * np.sin(path.yaw[selected])
    y = path.y[selected] + offset * np.cos(path.yaw[selected])
    return make_path(x, y, speed, path.z[selected])


def speed_limited_path(path: Path, lateral_accel: float, deceleration: float) -> Path:
    """Return the path with speed bounds for its bends, each reached with `deceleration` (both limits in m/s²)."""
    bounds = np.minimum(path.speed, curve_speed(path.curvature, lateral_accel))
    return replace(path, speed=limited_speed(path.s, bounds, deceleration))


def path_from_points(points: Sequence[DrivePoint], z: float) -> Path:
    """Return the line through explicit points at height `z` (m).

    Raises:
        ValueError: The points are too few or invalid.
    """
    if len(points) < 2:
        raise ValueError(f"a path must have at least 2 points, got {len(points)}")
    array = np.array(points, dtype=np.float64)
    if not np.all(np.isfinite(array)):
        raise ValueError("a path has a coordinate or speed that is not finite; drop or repair that point")
    if np.any(array[:-1, 2] <= 0.0):
        first = int(np.argmax(array[:-1, 2] <= 0.0))
        raise ValueError(f"point {first} of the path has a speed bound of 0, so the ego cannot pass it; use hold()")
    return make_path(array[:, 0], array[:, 1], array[:, 2], np.full(len(points), z))
