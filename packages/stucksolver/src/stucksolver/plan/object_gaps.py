"""Gaps from the body on a path to stationary objects, and what the guard can accept beside them."""

from __future__ import annotations

import numpy as np

from stucksolver.plan.behaviors.behavior import CREEP_MPS
from stucksolver.plan.frenet_path import STEP_M, FrenetPath
from stucksolver.scene.boxes import separation
from stucksolver.scene.frenet import Array
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.objects import VEHICLES

BESIDE_M = 0.05
"""Beginning of the sideways motion of a tracking fault (m): `TrackingPolicy.beside_m`."""
DRIFT_MPS = 0.25
"""Speed of that motion until the vehicle has stopped (m/s): `TrackingPolicy.drift_mps`."""
LAG_S = 0.3
"""Time until the brakes act (s): `StoppingPolicy.lag_s`."""
LEAST_GAP_M = 0.3
"""Least gap to a stationary object (m): `ClearancePolicy.standing_gap_m`."""
NEARER_M = 0.05
"""Least decrease of a gap that counts as approaching (m): `ClearancePolicy.nearer_m`."""
ERROR_M = 1.05
"""Gap toward which a committed path may lead (m): `TrackingPolicy.error_m` plus `HarmPolicy.touch_m`, and 5 cm."""
PARALLEL = 0.01
"""Slope below which a path leads toward nothing: `TrackingPolicy.parallel_rad`."""
TRACKED_M = 0.15
"""Part of a gap that a fault uses up before the guard notices it (m): `ClearancePolicy.tracked_gap_m`."""
DOOR_M, DOORS_PART = 0.9, 0.5
"""Reach of an open door (m), and the part of a vehicle's length in which its doors are: `DoorPolicy`."""
BESIDE_DOOR_M = 0.4
"""Gap to an open door for more than walking pace (m): a fault of 0.125 m, which the guard requires at any speed, and
the tracking error of a tight shift. Ours.
"""


def gaps(
    view: FrenetScene, path: FrenetPath, yaw_rad: float, which: Array, part: float = 1.0, aside_m: float = 0.0
) -> Array:
    """(stations, objects): gaps from the body on a path to the objects `which` (m).

    Args:
        view: Surroundings in road coordinates.
        path: Path.
        yaw_rad: Heading of the body at the start (rad).
        which: Indices of the objects.
        part: Part of the objects' length, around the middle, that counts.
        aside_m: Widening of the objects on each side (m).
    """
    return separation(
        (path.s[:, None], path.d[:, None], path.body(yaw_rad, view.ego.limits.wheelbase_m)[:, None]),
        (view.ego.length_m / 2, view.ego.width_m / 2),
        (view.s[which], view.d[which], view.yaw[which]),
        (part * view.half_length[which], view.half_width[which] + aside_m),
    )


def bounded_speed(view: FrenetScene, path: FrenetPath, yaw_rad: float) -> FrenetPath:
    """Return the same path, no faster than its lateral acceleration and its gaps to stationary objects allow.

    Only objects that the body approaches count. Walking pace is always allowed.

    Args:
        view: Surroundings in road coordinates.
        path: Path with upper bounds on the speed.
        yaw_rad: Heading of the body at the start (rad).
    """
    return path.no_quicker(np.minimum(_lateral_limit(view, path), _gap_limit(view, path, yaw_rad)))


def comes_too_near(view: FrenetScene, path: FrenetPath, yaw_rad: float) -> bool:
    """True if the body comes nearer to a stationary object on the path than the guard allows at any speed.

    Args:
        view: Surroundings in road coordinates.
        path: Path.
        yaw_rad: Heading of the body at the start (rad).
    """
    gap = gaps(view, path, yaw_rad, np.flatnonzero(~view.moving & ~view.vulnerable))
    return bool(((gap < LEAST_GAP_M) & (gap < gap[0] - NEARER_M)).any())


def lack_toward_objects(view: FrenetScene, path: FrenetPath, yaw_rad: float) -> float:
    """Return by how much a path is too near to the stationary objects that it leads toward (m); at most 0 if nowhere.

    Past the commit point the guard requires `ERROR_M` there, or the gap at which the path began to lead toward them.

    Args:
        view: Surroundings in road coordinates.
        path: Path through the oncoming lane.
        yaw_rad: Heading of the body at the start (rad).
    """
    which = np.flatnonzero(~view.moving)
    gap = gaps(view, path, yaw_rad, which)
    sides = np.sign(view.d[which] - path.d[:, None])
    toward = np.gradient(path.d, path.s)[:, None] * sides > PARALLEL
    begun = np.maximum.accumulate(np.where(toward, 0, np.arange(len(path.s))[:, None]), axis=0)
    least = np.minimum(ERROR_M, np.take_along_axis(gap, begun, axis=0) - NEARER_M)
    return float(np.where(toward, least - gap, 0.0).max(initial=0.0))


def _lateral_limit(view: FrenetScene, path: FrenetPath) -> Array:
    """(stations,): speed at the limit of lateral acceleration (m/s)."""
    if len(path.s) < 3:
        return np.full(len(path.s), np.inf)
    slope = np.gradient(path.d, STEP_M)
    bend = np.abs(np.diff(path.d, 2)) / STEP_M**2 / (1.0 + slope[1:-1] ** 2) ** 1.5
    result: Array = np.sqrt(view.ego.limits.max_lateral_acceleration_mps2 / np.maximum(np.pad(bend, 1), 1e-6))
    return result


def _gap_limit(view: FrenetScene, path: FrenetPath, yaw_rad: float) -> Array:
    """(stations,): speed at which each gap covers a tracking fault and an opening door (m/s)."""
    which = np.flatnonzero(~view.moving)
    if not len(which):
        return np.full(len(path.s), np.inf)
    gap = gaps(view, path, yaw_rad, which)
    takes_s = (gap - BESIDE_M - TRACKED_M) / DRIFT_MPS - LAG_S
    limit = np.maximum(takes_s * view.ego.limits.comfort_braking_mps2, CREEP_MPS)
    limit[gap >= gap[0] - NEARER_M] = np.inf
    vehicles = np.array([view.objects[int(i)].kind in VEHICLES for i in which], dtype=bool)
    doors = gaps(view, path, yaw_rad, which, DOORS_PART, DOOR_M)
    near = (doors < BESIDE_DOOR_M) & (doors < doors[0] - NEARER_M) & vehicles
    result: Array = np.where(near, np.minimum(limit, CREEP_MPS), limit).min(axis=1)
    return result
