"""Pulls out from the roadside, such as a parking lane: on the gentlest clear path, in an accepted gap."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import Path, PlanarPose
from stucksolver_carla.drivers.behavior.swept_path import nearest_hazards, sweep
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

ROADSIDE_M = 1.5
"""Distance from the route's line from which the ego is at the roadside (m). Ours."""
SIDE_MARGIN_M = 0.15
"""Clearance at the ego's sides between parked cars (m). Ours."""
GAP_S = 3.0
"""Accepted time gap to traffic (s). The ego then has about 4 m/s, and traffic at 50 km/h brakes with less than
3.5 m/s². Ours."""
MIN_GAP_S = 1.3
"""Accepted time gap after `PATIENCE_S` at the roadside (s): accepted gaps shrink with the time waited. Traffic at
10 m/s still brakes with less than 2 m/s². Ours."""
PATIENCE_S = 20.0
"""Wait after which the smallest gap is accepted (s). Ours."""
LENGTH_SHARES = (1.0, 0.85, 0.75, 0.65)
"""Shares of the gentle path length that are tried, the gentlest first. Ours."""
_STOPPED_MPS = 0.3
"""Speed below which an object counts as stopped (m/s). Ours."""
_REACH_M = 1.8
"""Travel over which the ego's offset from the path fades (m); see `SteerController.MIN_REACH_M`."""
_RANGE_M = 80.0
"""Length of the lane behind the ego in which traffic counts (m). Ours."""
_GAP_M = 1.0
"""Minimum gap to a vehicle behind or ahead (m). Ours."""
_LANE_M = 1.75
"""Maximum offset from the route's line of traffic in its lane (m): half a lane."""


def find_pull_out_path(
    rejoin_path: Callable[[float], Path],
    gentle_m: float,
    pose: PlanarPose,
    around: NearbyObjects,
    model: VehicleModel,
    margin_m: float = SIDE_MARGIN_M,
) -> Path | None:
    """Return the longest clear path back to the route; None without one.

    `rejoin_path` returns the path for a length (m). A path is clear if its swept path contains no stopped object.
    """
    stopped = around.part(np.hypot(around.vx, around.vy) < _STOPPED_MPS)
    for share in LENGTH_SHARES:
        path = rejoin_path(share * gentle_m)
        swept = sweep(path, path.project(pose), pose, model, _REACH_M, share * gentle_m)
        if not nearest_hazards(swept, stopped, model, margin_m, margin_m):
            return path
    return None


def moving_objects(around: NearbyObjects) -> NearbyObjects:
    """Return the objects that are not stopped."""
    return around.part(np.hypot(around.vx, around.vy) >= _STOPPED_MPS)


def accepted_gap_s(waited_s: float) -> float:
    """Return the accepted time gap after a wait (s)."""
    return GAP_S + min(waited_s / PATIENCE_S, 1.0) * (MIN_GAP_S - GAP_S)


def is_traffic_approaching(
    line: Path, route_s: float, ego_mps: float, around: NearbyObjects, model: VehicleModel, gap_s: float = GAP_S
) -> bool:
    """Return True if a vehicle is alongside the ego in the route's lane, or will be within `gap_s`."""
    for x, y, yaw, length, vx, vy in zip(
        around.x, around.y, around.yaw, around.half_length, around.vx, around.vy, strict=True
    ):
        projection = line.project(
            PlanarPose(float(x), float(y), float(yaw)), route_s - _RANGE_M + 3.0, window_m=_RANGE_M + 10.0
        )
        gap = route_s - projection.s - float(length) - model.half_length
        min_gap = -2.0 * (float(length) + model.half_length) - _GAP_M
        closing = max(float(np.hypot(vx, vy)) - ego_mps, 0.0)
        if abs(projection.lateral) < _LANE_M and min_gap < gap < gap_s * closing + _GAP_M:
            return True
    return False
