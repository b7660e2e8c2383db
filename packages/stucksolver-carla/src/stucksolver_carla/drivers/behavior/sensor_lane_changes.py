"""Lane changes of the base driver by sensors: it looks beside and behind first, and stays in its lane until there is
a gap.

With ground truth the base driver changes lanes where the route says, as CARLA's BehaviorAgent does.
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
from stucksolver_carla.drivers.behavior.route_lane_changes import SLOWER_MPS2, LaneChangePlanner, lane_changes
from stucksolver_carla.drivers.behavior.route_line import rejoining_length
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel
from stucksolver_carla.drivers.driver_interface import RoutePoint

JOINS_FROM_M = 0.5
"""The line is joined as from this far beside it (m)."""
ON_LINE_M = 1.0
"""An ego farther from its intended place does not choose another one (m)."""


class LineSituation(NamedTuple):
    """See `lane_changes.OnRoute`."""

    s_m: float
    d_m: float
    speed_mps: float
    cruise_mps: float
    bodies: RouteObjects
    model: VehicleModel


class SensorLaneChanges:
    """The lane changes of one route, each begun in a gap."""

    def __init__(self, route: Sequence[RoutePoint], line: Path | None, doubt_m: float) -> None:
        """`doubt_m`: how far bodies may be from where sensors see them (m)."""
        self._watch = LaneChangePlanner([] if line is None else lane_changes(route, line), doubt_m)
        self._shifts: list[LateralShift] = []
        self._lost = False
        """True if the ego is not where it means to be: then it looks for no gap."""

    def forget_line(self) -> None:
        """Another line than the one given last is driven."""
        self._shifts = []

    @property
    def pace_mps(self) -> float:
        """Pace of the lane that is being entered (m/s); 0 if none is."""
        return self._watch.pace_mps

    @property
    def entered(self) -> frozenset[int]:
        """Ids of those in the lane that is being entered."""
        return self._watch.judged

    def meant_m(self, s_m: float) -> float:
        """Return the intended offset from the route's line at an arc length of it (m, right positive)."""
        return float(offset_of(self._shifts, np.array([s_m]))[0])

    def other_line(self, line: Path, here: LineSituation, lateral_accel: float, deceleration: float) -> Path | None:
        """Look at the lane that is changed to. Return the line to drive from now on, if it is another one."""
        self._lost = abs(here.d_m - self.meant_m(here.s_m)) > ON_LINE_M
        if self._lost:
            return None
        self._watch.look(here)
        wanted = self._watch.shifts()
        if wanted == self._shifts:
            return None
        self._shifts = wanted
        join_m = rejoining_length(JOINS_FROM_M, here.speed_mps)
        return shifted_path(line, here.s_m, here.d_m, wanted, join_m, lateral_accel, deceleration)

    def allowed(self, concerns: AccelerationLimits, speed: float, behind_mps: float) -> float:
        """Return the acceleration that waiting for a gap allows: slower than the lane beside, to the end of its own.

        `behind_mps`: speed of who follows in the own lane (m/s). An ego that became slower than that would be hit.
        """
        if self._lost or self._watch.wait_m is None:
            return math.inf
        slips_back = max(max(self._watch.most_mps, behind_mps) - speed, -SLOWER_MPS2)
        return min(slips_back, concerns.stop_line(self._watch.wait_m, speed))
