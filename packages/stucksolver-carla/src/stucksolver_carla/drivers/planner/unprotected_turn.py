"""Across an oncoming stream on a square turn: with a run-up, in a proven gap, and without a stop in the stream.

From the waiting place before the junction the ego drives up to the stream at the speed at which it crosses it, but
only if the whole drive is proven to meet nobody. Until it can no longer stop before the stream it may still give up.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stucksolver_carla.drivers.behavior.acceleration_limits import PaceFactors
from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath, JunctionConflicts
from stucksolver_carla.drivers.behavior.ego_rollout import EgoRollout, Margin, can_stop, predict_drive
from stucksolver_carla.drivers.behavior.flow_speed import HURRIED
from stucksolver_carla.drivers.behavior.junction_yield import EgoSpeeds, YieldDecision
from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import Path
from stucksolver_carla.drivers.behavior.profiles import DriverProfile
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel
from stucksolver_carla.drivers.planner.flow_merge import FlowMergeYield
from stucksolver_carla.drivers.planner.square_turns import stream_ways

CROSSES = PaceFactors(2.0, 1.65)
"""How to cross: up to 4 m/s² ahead, and some 6 m/s² sideways, what tires hold on a wet road (0.6 g)."""
TO_CROSS = Margin(0.5, 0.08, 0.5, 0.05)
"""Kept free before and behind the others: at constant speed they and the ego are foretold to within a tenth of a
second.
"""
TO_GO_ON_CROSSING = Margin(0.3, 0.0, 0.2, 0.0)
"""For an ego that has set off, so that rounding does not make it give up."""
_PULL_AT_MPS, _PULL_MPS2 = (2.0, 6.0, 10.0, 16.0), (3.9, 3.1, 2.1, 1.9)
"""Highest accelerations (m/s²) at these speeds (m/s): CARLA's Lincoln at the highest throttle of this driver, 0.75, as
measured on carlette.
"""
HORIZON_S = 14.0
"""How far ahead the drive is foretold (s): 5 s to the stream, and `JOINED_S`."""
JOINED_S = 8.0
"""For so long after the ego has joined a stream nobody may come too near from behind (s): from 10 to 18 m/s it takes
4 s and more, and then the gap closes no more.
"""
IN_LANE_M = 25.0
"""So far behind the junction the vehicles in its lane still lie beside the route's line behind the ego (m)."""
LAG_S = 0.1
"""How long a standing ego takes to set off (s); one that takes longer gives up before the stream."""
RUN_UP_M = 8.0
"""Distance from the stream at which an ego that gives up stops if it can: enough to reach 6 m/s again."""
EDGE_M = 0.5
"""Distance kept from the stream by one that stops there (m)."""
GIVES_UP_MPS2 = 5.0
"""Deceleration with which it stops before the stream at the latest (m/s²)."""


def max_acceleration(speed: float) -> float:
    """Return the highest acceleration (m/s²) at a speed (m/s)."""
    return float(np.interp(speed, _PULL_AT_MPS, _PULL_MPS2))


def joined_streams(meeting: JunctionConflicts) -> list[ConflictPath]:
    """Return the straight ways with the right of way that the route joins at a junction."""
    return [way for way in meeting.ways if way.goes_first and way.straight and way.joins]


class UnprotectedTurnYield(FlowMergeYield):
    """Looks for a gap in the stream at `wait_s`, to cross or join it; elsewhere see `FlowMergeYield`."""

    def __init__(
        self,
        meetings: Sequence[JunctionConflicts],
        profile: DriverProfile,
        model: VehicleModel,
        line: Path,
        wait_s: float,
    ) -> None:
        super().__init__(meetings, profile, model, HURRIED)
        self._turn = min(meetings, key=lambda meeting: abs(meeting.wait_s - wait_s), default=None)
        self._streams = [] if self._turn is None else stream_ways(line, self._turn) or joined_streams(self._turn)

    def look(self, line: Path, s: float, motion: EgoSpeeds, around: NearbyObjects, dt_s: float) -> YieldDecision:
        """See `GiveWay`."""
        self._line = line
        self._forget(s)
        here = bool(self._due) and self._due[0] is self._turn and bool(self._streams)
        self.pace = CROSSES if here else HURRIED
        return self._cross(line, s, motion, around) if here else super().look(line, s, motion, around, dt_s)

    def _cross(self, line: Path, s: float, motion: EgoSpeeds, around: NearbyObjects) -> YieldDecision:
        meeting, front = self._due[0], s + self._model.half_length
        coming = self._coming(meeting, around)
        drive = self._drive(line, s, motion.speed, self._top_mps(motion, coming))
        edge_s = min(way.route_meets_s for way in self._streams) - EDGE_M
        going = self._going is meeting
        found = drive.judge(coming, TO_GO_ON_CROSSING if going else TO_CROSS)
        if going and not can_stop(motion.speed, edge_s - front, GIVES_UP_MPS2):
            # In the stream it only drives on: whoever it was proven against would run into a stop.
            stream = frozenset(other.actor_id for way, other in coming if way in self._streams and not way.joins)
            across = front > max((way.route_parts_s for way in self._streams if not way.joins), default=-math.inf)
            return YieldDecision(None, found.passing | stream, None, found.leader if across else None)
        if not found.met:
            self._going = meeting
            return YieldDecision(None, found.passing)
        self._going = None
        others_s = [way.route_meets_s - EDGE_M for way in found.met if way.route_meets_s > front + EDGE_M]
        return YieldDecision(self._stop_m(meeting, min([edge_s, *others_s]), front, motion.speed), frozenset())

    def _drive(self, line: Path, s: float, speed: float, top_mps: float) -> EgoRollout:
        """See `GiveWay`."""
        if self.pace is not CROSSES:
            return super()._drive(line, s, speed, top_mps)
        lag_s = 0.0 if self.going else LAG_S
        gone = predict_drive(
            line, s, speed, top_mps, self._profile, self.pace.bends, lag_s, max_acceleration, HORIZON_S
        )
        return EgoRollout(line, gone, self._model, slips=True, joined_s=JOINED_S)

    def _forget(self, s: float) -> None:
        """See `GiveWay`; a stream that it has joined sets its pace until it drives in its lane like everybody else."""
        joins = any(way.joins for way in self._streams)
        here = self._due[0] if self._due else None
        stays_m = IN_LANE_M if joins and here is self._turn else 0.0
        super()._forget(s - stays_m)

    def _stop_m(self, meeting: JunctionConflicts, edge_s: float, front: float, speed: float) -> float:
        """Return the distance to where to wait: before the junction, a run-up before the stream, or at its edge."""
        at_once = speed * speed / (2.0 * self._profile.deceleration)
        if can_stop(speed, meeting.wait_s - front, self._profile.deceleration):
            return meeting.wait_s - front
        return min(max(edge_s - RUN_UP_M - front, at_once), edge_s - front)
