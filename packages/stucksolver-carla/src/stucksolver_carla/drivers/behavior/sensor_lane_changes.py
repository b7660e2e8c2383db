"""Changes the base driver's lanes in sensor mode: only when it has accepted a gap.

With ground truth the base driver changes lanes where the route does, as CARLA's BehaviorAgent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stucksolver_carla.drivers.behavior.acceleration_limits import AccelerationLimits
from stucksolver_carla.drivers.behavior.lateral_offsets import LateralShift, offset_of, shifted_path
from stucksolver_carla.drivers.behavior.path import Path
from stucksolver_carla.drivers.behavior.route_bodies import RouteObjects
from stucksolver_carla.drivers.behavior.route_lane_changes import DECELERATION_MPS2, LaneChangePlanner, lane_changes
from stucksolver_carla.drivers.behavior.route_line import rejoining_length
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel
from stucksolver_carla.drivers.driver_interface import RoutePoint

JOIN_OFFSET_M = 0.5
"""Offset for which the length of the transition to a new line is computed (m). Ours."""
ON_LINE_M = 1.0
"""Maximum distance from the intended line at which the ego may choose another one (m). Ours."""


class LineSituation(NamedTuple):
    """The ego on the route's line; see `RouteSituation`."""

    s_m: float
    d_m: float
    speed_mps: float
    cruise_mps: float
    bodies: RouteObjects
    model: VehicleModel


class SensorLaneChanges:
    """The lane changes of one route, each in an accepted gap."""

    def __init__(self, route: Sequence[RoutePoint], line: Path | None, doubt_m: float) -> None:
        """Create the lane changes. `doubt_m`: maximum error of the objects' positions (m)."""
        self._planner = LaneChangePlanner([] if line is None else lane_changes(route, line), doubt_m)
        self._shifts: list[LateralShift] = []
        self._is_off_line = False
        """True if the ego is not on its intended line. It then chooses no gap."""

    def forget_line(self) -> None:
        """Drop the last line, because the ego drives another one."""
        self._shifts = []

    @property
    def pace_mps(self) -> float:
        """Speed of the lane that the ego enters (m/s); 0 without one."""
        return self._planner.pace_mps

    @property
    def entered_lane_ids(self) -> frozenset[int]:
        """Ids of the vehicles in the lane that the ego enters."""
        return self._planner.checked_ids

    def intended_offset_m(self, s_m: float) -> float:
        """Return the intended offset from the route's line at an arc length of it (m, right positive)."""
        return float(offset_of(self._shifts, np.array([s_m]))[0])

    def other_line(
        self, line: Path, situation: LineSituation, lateral_accel: float, deceleration: float
    ) -> Path | None:
        """Update the decisions for one tick. Return a new line to drive; None to keep the present one."""
        self._is_off_line = abs(situation.d_m - self.intended_offset_m(situation.s_m)) > ON_LINE_M
        if self._is_off_line:
            return None
        self._planner.update(situation)
        shifts = self._planner.shifts()
        if shifts == self._shifts:
            return None
        self._shifts = shifts
        join_m = rejoining_length(JOIN_OFFSET_M, situation.speed_mps)
        return shifted_path(line, situation.s_m, situation.d_m, shifts, join_m, lateral_accel, deceleration)

    def allowed_acceleration(self, concerns: AccelerationLimits, speed: float, rear_mps: float) -> float:
        """Return the acceleration while the ego waits for a gap: slower than the adjacent lane, up to its lane's end.

        `rear_mps` is the speed of the follower in the ego's lane (m/s). A slower ego would be hit.
        """
        if self._is_off_line or self._planner.wait_m is None:
            return math.inf
        fall_back_mps2 = max(max(self._planner.max_mps, rear_mps) - speed, -DECELERATION_MPS2)
        return min(fall_back_mps2, concerns.stop_line(self._planner.wait_m, speed))
