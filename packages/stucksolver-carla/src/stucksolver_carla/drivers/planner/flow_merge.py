"""Merges into a traffic flow at the flow's speed, also if that is above the reported speed limit.

CARLA reports the limit of the last sign passed. If a whole flow drives faster, a car at the old limit is hit from
behind by traffic that does not brake.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath, JunctionConflicts
from stucksolver_carla.drivers.behavior.conflicting_traffic import ConflictingVehicle, flow_speed_mps
from stucksolver_carla.drivers.behavior.ego_rollout import PredictedConflict, can_stop
from stucksolver_carla.drivers.behavior.junction_yield import (
    FASTEST_MPS,
    FULL_MPS2,
    EgoSpeeds,
    JunctionYield,
    YieldDecision,
)
from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import Path
from stucksolver_carla.drivers.planner.crossing_cyclists import crossing_riders

BEHIND_M = 2.0
"""Distance from the ego's rear to a vehicle's rear, behind it, from which that vehicle is no lead vehicle (m). Ours."""
_SAME_POSITION_M = 0.1
"""Difference of arc length below which two stops are the same (m). Ours."""


class FlowMergeYield(JunctionYield):
    """The decisions at junctions with merges at the flow's speed; see `JunctionYield`."""

    committed_m: ClassVar[float] = 4.0
    may_wait_in_path: ClassVar[bool] = True
    flow_mps = 0.0
    """Speed of the flow that the ego joins at the junction ahead (m/s); 0 without one."""
    _line: Path | None = None
    checked_ids: frozenset[int] = frozenset()
    """Ids of the vehicles on conflict paths for which the last decision checked the drive through the junction."""

    def decide(self, line: Path, s: float, motion: EgoSpeeds, around: NearbyObjects, dt_s: float) -> YieldDecision:
        """Return the decision, as in `JunctionYield`, without lead vehicles that are behind the ego."""
        self.flow_mps, self.checked_ids, self._line = 0.0, frozenset(), line
        decision = super().decide(line, s, motion, around, dt_s)
        if decision.leader is not None and decision.leader.gap_m < -2.0 * self._model.half_length - BEHIND_M:
            # That vehicle reached the junction first, but the ego has joined ahead of it.
            return decision._replace(leader=None)
        return decision

    def _conflicting_traffic(
        self, junction: JunctionConflicts, around: NearbyObjects
    ) -> list[tuple[ConflictPath, ConflictingVehicle]]:
        """Return the traffic, as in `JunctionYield`, and the cyclists outside the car lanes."""
        cyclists = [] if self._line is None else crossing_riders(self._line, junction, around)
        return super()._conflicting_traffic(junction, around) + cyclists

    def _committed_decision(
        self, junction: JunctionConflicts, decision: PredictedConflict, front: float, speed: float
    ) -> YieldDecision:
        """Return the decision past the waiting place: with a conflict, stop before the next path not yet entered."""
        default = super()._committed_decision(junction, decision, front, speed)
        if default.wait_m is not None or not decision.met:
            return default
        limit = min((path.route_meets_s for path in decision.met if path.route_meets_s > front), default=front)
        stops_s = {path.route_meets_s for path in junction.ways if front < path.route_meets_s <= limit}
        rooms_m = [stop_s - front for stop_s in stops_s if self._enters_no_path(junction, front, stop_s)]
        room_m = max((item for item in rooms_m if can_stop(speed, item, FULL_MPS2)), default=None)
        return default if room_m is None else YieldDecision(room_m, frozenset())

    def _enters_no_path(self, junction: JunctionConflicts, front: float, stop_s: float) -> bool:
        """Return True if an ego that stops at `stop_s` is in no priority path that it has not entered already."""
        paths_ahead = [path for path in junction.ways if path.goes_first and path.route_meets_s > front]
        return not any(path.route_meets_s < stop_s - _SAME_POSITION_M for path in paths_ahead)

    def _lag_s(self) -> float:
        """Return the delay of the start (s). After the start it is 0; otherwise the ego would seem late and stop."""
        return 0.0 if self.has_started else super()._lag_s()

    def _top_mps(self, motion: EgoSpeeds, traffic: Sequence[tuple[ConflictPath, ConflictingVehicle]]) -> float:
        flow_mps = flow_speed_mps(traffic)
        self.checked_ids = frozenset(item.actor_id for _, item in traffic)
        self.flow_mps = min(flow_mps, FASTEST_MPS) if math.isfinite(flow_mps) else 0.0
        return self.flow_mps or motion.top_mps
