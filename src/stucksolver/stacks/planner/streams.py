"""Into a stream at its own pace: who joins one that is faster than the limit known drives as fast as it does.

CARLA tells the limit of the last sign that was passed. Where a whole stream drives faster, a car that keeps to the old
limit is run into from behind by whoever does not brake.
"""

from __future__ import annotations

import math

from stucksolver.stacks.driver.behavior import Profile
from stucksolver.stacks.driver.concerns import Concerns, Pace
from stucksolver.stacks.driver.give_way import BRISK, GiveWay, Moving
from stucksolver.stacks.driver.local_planner import LocalPlanner
from stucksolver.stacks.driver.options import DriverOptions
from stucksolver.stacks.driver.path import Path
from stucksolver.stacks.driver.vehicle_model import VehicleModel

FASTEST_MPS = 22.0
"""No stream is joined at more than this."""


class StreamGiveWay(GiveWay):
    """Looks for a gap as one who takes up the stream's pace; see `GiveWay`."""

    flow_mps = 0.0
    """Pace of the stream that the ego joins at the junction ahead (m/s); 0 without one."""

    def _top_mps(self, motion: Moving, flow_mps: float) -> float:
        self.flow_mps = min(flow_mps, FASTEST_MPS) if math.isfinite(flow_mps) else 0.0
        return self.flow_mps or motion.top_mps


class StreamConcerns(Concerns):
    """The driver's concerns, with a stream's pace in place of a lower limit."""

    def __init__(self, profile: Profile, options: DriverOptions, model: VehicleModel, planner: LocalPlanner) -> None:
        super().__init__(profile, options, model, planner)
        self.flow_mps = 0.0
        """Pace of the stream that the ego joins or has just joined (m/s); 0 without one."""

    def cruise(self, path: Path, speed: float, limit_kmh: float, command: str, pace: Pace) -> float:
        """Keep to the path's bounds and to the limit, or to the pace of the stream where that is faster."""
        joins = self.flow_mps > super().top_speed(limit_kmh)
        return super().cruise(path, speed, limit_kmh, "" if joins else command, BRISK if joins else pace)

    def top_speed(self, limit_kmh: float) -> float:
        """See `Concerns`; the stream's pace where that is faster."""
        return max(super().top_speed(limit_kmh), self.flow_mps)
