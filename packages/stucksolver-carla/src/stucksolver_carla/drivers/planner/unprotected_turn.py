"""Crosses an oncoming flow on a square turn: with a run-up, in an accepted gap, and without a stop inside the flow.

From the waiting place before the junction the ego accelerates to the speed at which it crosses the flow. It starts only
if the rollout of the whole drive has no conflict. It may abort as long as it can stop before the flow.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stucksolver_carla.drivers.behavior.acceleration_limits import PaceFactors
from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath, JunctionConflicts
from stucksolver_carla.drivers.behavior.ego_rollout import EgoRollout, Margin, can_stop, predict_drive
from stucksolver_carla.drivers.behavior.flow_speed import FLOW_MERGE
from stucksolver_carla.drivers.behavior.junction_yield import EgoSpeeds, YieldDecision
from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import Path
from stucksolver_carla.drivers.behavior.profiles import DriverProfile
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel
from stucksolver_carla.drivers.planner.flow_merge import FlowMergeYield
from stucksolver_carla.drivers.planner.square_turns import oncoming_paths

CROSSING_PACE = PaceFactors(2.0, 1.65)
"""Pace of a crossing: accelerations up to 4 m/s² ahead and about 6 m/s² sideways, the grip of a wet road (0.6 g)."""
CROSS_MARGIN = Margin(0.5, 0.08, 0.5, 0.05)
"""Required gap for the start: at constant speed, ego and traffic are predicted to within 0.1 s. Ours."""
CROSS_COMMITTED_MARGIN = Margin(0.3, 0.0, 0.2, 0.0)
"""Required gap after the start. It is smaller, so that rounding does not cause an abort. Ours."""
_FULL_THROTTLE_AT_MPS, _FULL_THROTTLE_MPS2 = (2.0, 6.0, 10.0, 16.0), (3.9, 3.1, 2.1, 1.9)
"""Highest accelerations (m/s²) at these speeds (m/s): CARLA's Lincoln at the highest throttle of this driver, 0.75, as
measured on carlette.
"""
HORIZON_S = 14.0
"""Horizon of the rollout (s): 5 s to the flow, and `JOINED_S`."""
JOINED_S = 8.0
"""Time after a merge during which the rear gap must hold (s). From 10 to 18 m/s the ego takes 4 s and more, and then
the gap no longer shrinks."""
IN_LANE_M = 25.0
"""Length after the junction over which rear vehicles still follow the route line (m). Ours."""
LAG_S = 0.1
"""Delay of the start of a stopped ego (s). An ego with a longer delay aborts before the flow. Ours."""
RUN_UP_M = 8.0
"""Distance to the flow at which an ego that aborts stops, if possible (m): enough to reach 6 m/s again. Ours."""
EDGE_M = 0.5
"""Distance to the flow at the last possible stop (m). Ours."""
ABORT_MPS2 = 5.0
"""Deceleration of the last possible stop before the flow (m/s²). Ours."""


def max_acceleration(speed: float) -> float:
    """Return the highest acceleration (m/s²) at a speed (m/s)."""
    return float(np.interp(speed, _FULL_THROTTLE_AT_MPS, _FULL_THROTTLE_MPS2))


def joined_paths(junction: JunctionConflicts) -> list[ConflictPath]:
    """Return the straight paths with the right of way that the route joins at a junction."""
    return [path for path in junction.ways if path.goes_first and path.straight and path.joins]


class UnprotectedTurnYield(FlowMergeYield):
    """The decisions with a crossing or merge of the flow at `wait_s`; for other junctions see `FlowMergeYield`."""

    def __init__(
        self,
        junctions: Sequence[JunctionConflicts],
        profile: DriverProfile,
        model: VehicleModel,
        line: Path,
        wait_s: float,
    ) -> None:
        super().__init__(junctions, profile, model, FLOW_MERGE)
        self._turn = min(junctions, key=lambda junction: abs(junction.wait_s - wait_s), default=None)
        self._flow_paths = [] if self._turn is None else oncoming_paths(line, self._turn) or joined_paths(self._turn)

    def decide(self, line: Path, s: float, motion: EgoSpeeds, around: NearbyObjects, dt_s: float) -> YieldDecision:
        """Return the decision: for a crossing at this class's junction, as in `FlowMergeYield` elsewhere."""
        self._line = line
        self._drop_passed(s)
        is_here = bool(self._due) and self._due[0] is self._turn and bool(self._flow_paths)
        self.pace = CROSSING_PACE if is_here else FLOW_MERGE
        return (
            self._crossing_decision(line, s, motion, around)
            if is_here
            else super().decide(line, s, motion, around, dt_s)
        )

    def _crossing_decision(self, line: Path, s: float, motion: EgoSpeeds, around: NearbyObjects) -> YieldDecision:
        junction, front = self._due[0], s + self._model.half_length
        traffic = self._conflicting_traffic(junction, around)
        rollout = self._rollout(line, s, motion.speed, self._top_mps(motion, traffic))
        edge_s = min(path.route_meets_s for path in self._flow_paths) - EDGE_M
        has_started = self._going is junction
        conflict = rollout.predict_conflict(traffic, CROSS_COMMITTED_MARGIN if has_started else CROSS_MARGIN)
        if has_started and not can_stop(motion.speed, edge_s - front, ABORT_MPS2):
            # Inside the flow the ego only continues. The vehicles for which it was checked would hit a stopped ego.
            flow_ids = frozenset(
                other.actor_id for path, other in traffic if path in self._flow_paths and not path.joins
            )
            is_across = front > max(
                (path.route_parts_s for path in self._flow_paths if not path.joins), default=-math.inf
            )
            return YieldDecision(None, conflict.passing | flow_ids, None, conflict.leader if is_across else None)
        if not conflict.met:
            self._going = junction
            return YieldDecision(None, conflict.passing)
        self._going = None
        stops_s = [path.route_meets_s - EDGE_M for path in conflict.met if path.route_meets_s > front + EDGE_M]
        return YieldDecision(self._stop_m(junction, min([edge_s, *stops_s]), front, motion.speed), frozenset())

    def _rollout(self, line: Path, s: float, speed: float, top_mps: float) -> EgoRollout:
        """Return the rollout: with the vehicle's acceleration for a crossing, as in `JunctionYield` elsewhere."""
        if self.pace is not CROSSING_PACE:
            return super()._rollout(line, s, speed, top_mps)
        lag_s = 0.0 if self.has_started else LAG_S
        arc_lengths = predict_drive(
            line, s, speed, top_mps, self._profile, self.pace.bends, lag_s, max_acceleration, HORIZON_S
        )
        return EgoRollout(line, arc_lengths, self._model, slips=True, joined_s=JOINED_S)

    def _drop_passed(self, s: float) -> None:
        """Drop the junctions behind the ego; a joined flow later, when its vehicles follow the route line."""
        joins_flow = any(path.joins for path in self._flow_paths)
        junction = self._due[0] if self._due else None
        extra_m = IN_LANE_M if joins_flow and junction is self._turn else 0.0
        super()._drop_passed(s - extra_m)

    def _stop_m(self, junction: JunctionConflicts, edge_s: float, front: float, speed: float) -> float:
        """Return the distance to the stop (m): before the junction, a run-up before the flow, or at its edge."""
        shortest_m = speed * speed / (2.0 * self._profile.deceleration)
        if can_stop(speed, junction.wait_s - front, self._profile.deceleration):
            return junction.wait_s - front
        return min(max(edge_s - RUN_UP_M - front, shortest_m), edge_s - front)
