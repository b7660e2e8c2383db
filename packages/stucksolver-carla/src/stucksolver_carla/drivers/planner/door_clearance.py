"""Room beside parked vehicles, whose doors may open: within its own lane the ego keeps away from them.

Neither CARLA nor its client reports a door before somebody runs into it, so the room must be there beforehand.
"""

from __future__ import annotations

import numpy as np

from stucksolver_carla.drivers.behavior.lateral_offsets import LateralShift
from stucksolver_carla.drivers.behavior.route_bodies import Flags, RouteObjects
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel
from stucksolver_carla.drivers.planner.adjacent_lane_widths import AdjacentLaneWidths, LaneWidths
from stucksolver_carla.drivers.planner.pass_planner import TWO_WHEELER_M

DOOR_M = 0.9
"""How far an open front door sticks out (m)."""
BEYOND_DOOR_M = 0.25
"""Clearance kept beside the door (m)."""
IN_LANE_M = 0.15
"""Distance kept from the edge of the ego's lane (m)."""
LOOKS_M = 70.0
LEAST_M = 0.08
"""A smaller shift is not worth it."""
BEFORE_M = 6.0
"""Distance between the bumpers at which the room must be reached."""
AFTER_M = 2.0
OVER_S = 2.0
"""Seconds of our drive over which the ego moves aside."""
OVER_M = 10.0
"""The same, at least, in meters."""
_STANDS_MPS = 0.2
_STRADDLES_M = 0.4


class Berths:
    """Remembers beside whom the ego keeps away, so that it does not weave while passing."""

    def __init__(self) -> None:
        self._kept: dict[int, LateralShift] = {}

    def look(
        self, bodies: RouteObjects, s_m: float, speed_mps: float, sides: AdjacentLaneWidths, model: VehicleModel
    ) -> list[LateralShift]:
        """Return the shifts wanted now, for the ego with its center at `s_m` at that speed."""
        parked = parked_beside(bodies, s_m, model)
        ids = bodies.actor_id
        self._kept = {
            item: shift
            for item, shift in self._kept.items()
            if s_m < shift.back_m and (s_m > shift.returns_m or item in ids[parked])
        }
        for k in np.flatnonzero(parked).tolist():
            if int(ids[k]) not in self._kept:
                shift = _berth(bodies, k, s_m, speed_mps, sides, model)
                if shift is not None:
                    self._kept[int(ids[k])] = shift
        return sorted(self._kept.values(), key=lambda shift: shift.begins_m)


def parked_beside(bodies: RouteObjects, s_m: float, model: VehicleModel) -> Flags:
    """Return the vehicles with doors that stand ahead, or abreast, beside the ego's lane."""
    ahead = (bodies.s + bodies.along > s_m - model.half_length) & (bodies.s < s_m + LOOKS_M)
    cars = ~bodies.is_walker & (bodies.aside >= TWO_WHEELER_M) & (bodies.along > bodies.aside)
    return np.asarray(ahead & cars & (bodies.speed < _STANDS_MPS))


def _berth(
    bodies: RouteObjects, k: int, s_m: float, speed_mps: float, sides: AdjacentLaneWidths, model: VehicleModel
) -> LateralShift | None:
    start, end = float(bodies.s[k] - bodies.along[k]), float(bodies.s[k] + bodies.along[k])
    d, free = float(bodies.d[k]), abs(float(bodies.d[k])) - float(bodies.aside[k])
    room = sides.room(start, end)
    if not _is_off_the_road(room, d, free):
        return None
    wanted = model.half_width + DOOR_M + BEYOND_DOOR_M - free
    offset = min(wanted, room.half - model.half_width - IN_LANE_M)
    if offset < LEAST_M:
        return None
    half, over = model.half_length, max(OVER_S * speed_mps, OVER_M)
    beside = max(start - half - BEFORE_M, s_m + OVER_M)
    returns = end + half + AFTER_M
    away = -offset if d > 0.0 else offset
    return LateralShift(away, max(beside - over, s_m), beside, returns, returns + over) if returns > beside else None


def _is_off_the_road(room: LaneWidths, d_m: float, free_m: float) -> bool:
    """True if it stands beyond the driving lanes: parked, not queueing. Unknown if no lane is beside."""
    if max(room[1:]) <= 0.0:
        return False
    edge = room.half + (room.right_same if d_m > 0.0 else room.left_same + room.left_oncoming)
    return free_m > edge - _STRADDLES_M
