"""Leaves a place at the roadside, such as a parking lane: the gentlest turn that is clear, when nobody comes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import Path, PlanarPose
from stucksolver_carla.drivers.behavior.swept_path import nearest_hazards, sweep
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

BESIDE_M = 1.5
"""Further than this from the route's line the ego stands beside its lane."""
SIDE_MARGIN_M = 0.15
"""Clearance beside the body on the way out from between parked cars."""
GAP_S = 3.0
"""Accepted time gap to traffic: it meets a vehicle at some 4 m/s, and brakes for it by less than 3.5 m/s² from 50
km/h.
"""
LEAST_GAP_S = 1.3
"""Accepted after `PATIENCE_S` at the roadside: accepted gaps shrink with the time waited. Traffic at 10 m/s still
brakes by less than 2 m/s².
"""
PATIENCE_S = 20.0
TIGHTER = (1.0, 0.85, 0.75, 0.65)
_STANDS_MPS = 0.3
_REACH_M = 1.8
_SEEN_M = 80.0
_ROOM_M = 1.0
_LANE_M = 1.75


def find_pull_out_path(
    ways: Callable[[float], Path],
    gentle_m: float,
    pose: PlanarPose,
    around: NearbyObjects,
    model: VehicleModel,
    margin_m: float = SIDE_MARGIN_M,
) -> Path | None:
    """Of the ways back to the route that `ways` gives for a length, return the longest that meets no standing body."""
    standing = around.part(np.hypot(around.vx, around.vy) < _STANDS_MPS)
    for share in TIGHTER:
        way = ways(share * gentle_m)
        swept = sweep(way, way.project(pose), pose, model, _REACH_M, share * gentle_m)
        if not nearest_hazards(swept, standing, model, margin_m, margin_m):
            return way
    return None


def moving(around: NearbyObjects) -> NearbyObjects:
    """Return the bodies that do not stand."""
    return around.part(np.hypot(around.vx, around.vy) >= _STANDS_MPS)


def accepted_gap_s(waited_s: float) -> float:
    """Return the accepted time gap after this long a wait (s)."""
    return GAP_S + min(waited_s / PATIENCE_S, 1.0) * (LEAST_GAP_S - GAP_S)


def is_traffic_approaching(
    line: Path, route_s: float, own_mps: float, around: NearbyObjects, model: VehicleModel, gap_s: float = GAP_S
) -> bool:
    """True if anybody is abreast of the ego in the route's lane, or will be within `gap_s`."""
    for x, y, yaw, length, vx, vy in zip(
        around.x, around.y, around.yaw, around.half_length, around.vx, around.vy, strict=True
    ):
        place = line.project(
            PlanarPose(float(x), float(y), float(yaw)), route_s - _SEEN_M + 3.0, window_m=_SEEN_M + 10.0
        )
        gap = route_s - place.s - float(length) - model.half_length
        abreast = -2.0 * (float(length) + model.half_length) - _ROOM_M
        closing = max(float(np.hypot(vx, vy)) - own_mps, 0.0)
        if abs(place.lateral) < _LANE_M and abreast < gap < gap_s * closing + _ROOM_M:
            return True
    return False
