"""Speed signs of a map, as the boxes that set a vehicle's limit when it touches them.

CARLA gives a vehicle 30 km/h when it is spawned, and a sign's limit when it touches the sign's trigger box
(`WheeledVehicleAIController.h`, `SpeedLimitComponent.cpp`). The `<speed>` of a road or lane has no part in it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from carlette.geometry import Floats
from carlette.opendrive.traffic_side import runs_back

UNSIGNED_KMH = 30.0
"""A vehicle's limit until it passes a sign (km/h). As in CARLA."""
SPEED_SIGN = "274"
"""OpenDRIVE type of a sign with a maximum speed."""
BOX_SHARE = 0.35
"""Half edge of a sign's box, as a share of the lane's width. The box is a cube on the lane that ends at the sign."""
LEAST_HALF_M = 0.01
"""Smallest half edge of a box, on a lane that just begins (m). Ours."""


@dataclass(frozen=True, eq=False)
class SpeedBoxes:
    """One row for each pair of a sign and a driving lane for which it is valid."""

    center: Floats
    """(n, 3) World frame, m; on the road's surface."""
    yaw: Floats
    """(n) rad, along the lane."""
    half: Floats
    """(n) Half an edge, m."""
    kmh: Floats
    """(n)"""

    def __len__(self) -> int:
        return len(self.kmh)


def read_speed_boxes(carla: Any, town: Any) -> SpeedBoxes:
    """Return the boxes of all speed signs with a positive value. It counts as km/h for any unit, as in CARLA.

    `carla` is the client's module, `town` its map.
    """
    rows = []
    for sign in town.get_all_landmarks_of_type(SPEED_SIGN):
        if sign.value > 0.0:
            rows += [(*place, sign.value) for place in _places(carla, town, sign)]
    table = np.array(rows).reshape(-1, 6)
    return SpeedBoxes(table[:, :3], np.radians(table[:, 3]), table[:, 4], table[:, 5])


def _places(carla: Any, town: Any, sign: Any) -> list[tuple[float, float, float, float, float]]:
    """Return x, y, z (m), yaw (degrees) and half edge (m) of the sign's box on each driving lane that it governs."""
    places = []
    for first, last in sign.get_lane_validities():
        for lane in range(min(first, last), max(first, last) + 1):
            at = town.get_waypoint_xodr(sign.road_id, lane, sign.s) if lane else None
            if at is None or at.lane_type != carla.LaneType.Driving:
                continue
            half_m = max(BOX_SHARE * at.lane_width, LEAST_HALF_M)
            before = town.get_waypoint_xodr(sign.road_id, lane, sign.s + (half_m if runs_back(at) else -half_m)) or at
            transform = before.transform
            where = transform.location
            places.append((where.x, where.y, where.z, transform.rotation.yaw, half_m))
    return places
