"""Keeps clearance to parked vehicles, whose doors may open, by shifts inside the ego's lane.

Neither CARLA nor its client reports a door before a collision, so the clearance must exist beforehand.
"""

from __future__ import annotations

import numpy as np

from stucksolver_carla.drivers.behavior.lateral_offsets import LateralShift
from stucksolver_carla.drivers.behavior.route_bodies import Flags, RouteObjects
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel
from stucksolver_carla.drivers.planner.adjacent_lane_widths import AdjacentLaneWidths, LaneWidths
from stucksolver_carla.drivers.planner.pass_planner import TWO_WHEELER_M

DOOR_M = 0.9
"""Distance by which an open front door extends from the vehicle (m). Ours."""
BEYOND_DOOR_M = 0.25
"""Clearance to the open door (m). Ours."""
IN_LANE_M = 0.15
"""Distance to the edge of the ego's lane (m). Ours."""
RANGE_M = 70.0
"""Distance ahead within which parked vehicles count (m). Ours."""
MIN_OFFSET_M = 0.08
"""Minimum offset of a shift (m). Ours."""
BEFORE_M = 6.0
"""Distance between the bumpers at which the offset must be reached (m). Ours."""
AFTER_M = 2.0
"""Distance after the parked vehicle at which the return starts (m). Ours."""
SHIFT_S = 2.0
"""Duration of the lateral motion (s). Ours."""
MIN_SHIFT_M = 10.0
"""Minimum length of the lateral motion (m). Ours."""
_STOPPED_MPS = 0.2
"""Speed below which a vehicle counts as stopped (m/s). Ours."""
_OVERLAP_M = 0.4
"""Maximum overlap of a parked vehicle with the driving lanes (m). Ours."""


class DoorClearance:
    """The shifts for parked vehicles. They are stored until the ego has passed, so that it does not weave."""

    def __init__(self) -> None:
        self._shifts: dict[int, LateralShift] = {}

    def update(
        self, bodies: RouteObjects, s_m: float, speed_mps: float, sides: AdjacentLaneWidths, model: VehicleModel
    ) -> list[LateralShift]:
        """Return the present shifts for an ego with its center at `s_m`."""
        is_parked_now = is_parked(bodies, s_m, model)
        ids = bodies.actor_id
        self._shifts = {
            actor_id: shift
            for actor_id, shift in self._shifts.items()
            if s_m < shift.back_m and (s_m > shift.returns_m or actor_id in ids[is_parked_now])
        }
        for k in np.flatnonzero(is_parked_now).tolist():
            if int(ids[k]) not in self._shifts:
                shift = _shift_for(bodies, k, s_m, speed_mps, sides, model)
                if shift is not None:
                    self._shifts[int(ids[k])] = shift
        return sorted(self._shifts.values(), key=lambda shift: shift.begins_m)


def is_parked(bodies: RouteObjects, s_m: float, model: VehicleModel) -> Flags:
    """Return True for stopped vehicles with doors, ahead of the ego or alongside."""
    is_ahead = (bodies.s + bodies.along > s_m - model.half_length) & (bodies.s < s_m + RANGE_M)
    has_doors = ~bodies.is_walker & (bodies.aside >= TWO_WHEELER_M) & (bodies.along > bodies.aside)
    return np.asarray(is_ahead & has_doors & (bodies.speed < _STOPPED_MPS))


def _shift_for(
    bodies: RouteObjects, k: int, s_m: float, speed_mps: float, sides: AdjacentLaneWidths, model: VehicleModel
) -> LateralShift | None:
    start, end = float(bodies.s[k] - bodies.along[k]), float(bodies.s[k] + bodies.along[k])
    d, free_m = float(bodies.d[k]), abs(float(bodies.d[k])) - float(bodies.aside[k])
    widths = sides.narrowest(start, end)
    if not _is_off_lanes(widths, d, free_m):
        return None
    wanted_m = model.half_width + DOOR_M + BEYOND_DOOR_M - free_m
    offset = min(wanted_m, widths.half - model.half_width - IN_LANE_M)
    if offset < MIN_OFFSET_M:
        return None
    half_length, length_m = model.half_length, max(SHIFT_S * speed_mps, MIN_SHIFT_M)
    beside_m = max(start - half_length - BEFORE_M, s_m + MIN_SHIFT_M)
    returns_m = end + half_length + AFTER_M
    offset_m = -offset if d > 0.0 else offset
    return (
        LateralShift(offset_m, max(beside_m - length_m, s_m), beside_m, returns_m, returns_m + length_m)
        if returns_m > beside_m
        else None
    )


def _is_off_lanes(widths: LaneWidths, d_m: float, free_m: float) -> bool:
    """Return True if a vehicle is outside the driving lanes, so parked and not in a queue.

    Without a known adjacent lane the result is False.
    """
    if max(widths[1:]) <= 0.0:
        return False
    right_m, left_m = widths.right_same + widths.right_oncoming, widths.left_same + widths.left_oncoming
    edge = widths.half + (right_m if d_m > 0.0 else left_m)
    return free_m > edge - _OVERLAP_M
