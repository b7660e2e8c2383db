"""Bounds the speed of a path beside stationary objects: the nearer they are, the slower."""

from __future__ import annotations

import numpy as np

from stucksolver.plan.behaviors.behavior import CREEP_MPS
from stucksolver.plan.frenet_path import STEP_M, FrenetPath
from stucksolver.plan.swept_body import Body
from stucksolver.scene.boxes import separation
from stucksolver.scene.frenet import Array
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.objects import VEHICLES

BESIDE_M, DRIFT_MPS, LAG_S = 0.05, 0.25, 0.3
"""Sideways motion of a tracking fault until the vehicle has stopped: its beginning (m), its speed (m/s), and the time
until the brakes act (s). `TrackingPolicy.beside_m`, `TrackingPolicy.drift_mps`, `StoppingPolicy.lag_s`.
"""
NEARER_M = 0.05
"""Least decrease of a gap that counts as approaching (m): `ClearancePolicy.nearer_m`."""
LEAST_GAP_M = 0.3
"""Least gap to a stationary object (m): `ClearancePolicy.standing_gap_m`."""
SPARE_M = 0.01
"""Part of a gap that is not used for the speed (m). Ours."""
DOOR_M, DOORS_PART = 0.95, 0.5
"""Least clearance from a vehicle's doors for more than walking pace (m), just over `DoorPolicy.reach_m`, and the part
of its length in which they are: `DoorPolicy.part_of_length`.
"""
SLOWEST_MPS = 1.0
"""Speed below which no gap bounds it further (m/s). Ours."""


def bounded_speed(view: FrenetScene, path: FrenetPath, yaw_rad: float) -> FrenetPath:
    """Return the same path, no faster than its lateral acceleration and its gaps to stationary objects allow.

    Only objects that the body approaches count.

    Args:
        view: Surroundings in road coordinates.
        path: Path with upper bounds on the speed.
        yaw_rad: Heading of the body at the start (rad).
    """
    limits = np.minimum(_lateral_limit(view, path), _gap_limit(view, path, yaw_rad))
    return path.no_quicker(limits)


def required_gap(view: FrenetScene, speed_mps: float | Array) -> Array:
    """Return the gap to a stationary object that covers a tracking fault at this speed (m)."""
    takes_s = LAG_S + np.asarray(speed_mps) / view.ego.limits.comfort_braking_mps2
    result: Array = np.maximum(LEAST_GAP_M, BESIDE_M + SPARE_M + DRIFT_MPS * takes_s)
    return result


def _lateral_limit(view: FrenetScene, path: FrenetPath) -> Array:
    """(stations,): speed at the limit of lateral acceleration (m/s)."""
    if len(path.s) < 3:
        return np.full(len(path.s), np.inf)
    slope = np.gradient(path.d, STEP_M)
    bend = np.abs(np.diff(path.d, 2)) / STEP_M**2 / (1.0 + slope[1:-1] ** 2) ** 1.5
    bend = np.pad(bend, 1, mode="edge")
    result: Array = np.sqrt(view.ego.limits.max_lateral_acceleration_mps2 / np.maximum(bend, 1e-6))
    return result


def _gap_limit(view: FrenetScene, path: FrenetPath, yaw_rad: float) -> Array:
    """(stations,): speed at which each gap covers a tracking fault and an opening door (m/s)."""
    which = np.flatnonzero(~view.moving)
    if not len(which):
        return np.full(len(path.s), np.inf)
    body = Body.of(view)
    yaw = path.body(yaw_rad, view.ego.limits.wheelbase_m)
    place = path.s[:, None], path.d[:, None], yaw[:, None]
    there = view.s[which], view.d[which], view.yaw[which]
    gap = separation(place, body.half, there, (view.half_length[which], view.half_width[which]))
    takes_s = (gap - BESIDE_M - SPARE_M) / DRIFT_MPS - LAG_S
    limit = np.maximum(takes_s * view.ego.limits.comfort_braking_mps2, SLOWEST_MPS)
    limit[gap >= gap[0] - NEARER_M] = np.inf
    vehicles = np.array([view.objects[int(i)].kind in VEHICLES for i in which], dtype=bool)
    doors = separation(place, body.half, there, (DOORS_PART * view.half_length[which], view.half_width[which]))
    near = (doors < DOOR_M) & (doors < doors[0] - NEARER_M) & vehicles
    result: Array = np.where(near, np.minimum(limit, CREEP_MPS), limit).min(axis=1)
    return result
