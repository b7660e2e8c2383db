"""Joins a stream at its own pace: a stream that is faster than the known limit is joined at its speed.

CARLA reports the limit of the last sign passed. If a whole stream drives faster, a car that keeps to the old limit is
hit from behind by traffic that does not brake.
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
"""A vehicle whose rear is farther behind our front than our length and this is no leader."""
_SAME_PLACE_M = 0.1


class FlowMergeYield(JunctionYield):
    """Looks for a gap at the stream's pace; see `JunctionYield`."""

    shown_m: ClassVar[float] = 4.0
    waits_with_its_nose_in: ClassVar[bool] = True
    flow_mps = 0.0
    """Pace of the stream that the ego joins at the junction ahead (m/s); 0 without one."""
    _line: Path | None = None
    judged: frozenset[int] = frozenset()
    """Ids of those on other ways against whom the drive through the junction was proven at the last look."""

    def look(self, line: Path, s: float, motion: EgoSpeeds, around: NearbyObjects, dt_s: float) -> YieldDecision:
        """See `JunctionYield`."""
        self.flow_mps, self.judged, self._line = 0.0, frozenset(), line
        found = super().look(line, s, motion, around, dt_s)
        if found.leader is not None and found.leader.gap_m < -2.0 * self._model.half_length - BEHIND_M:
            # It came to the junction first, but the ego has joined ahead of it.
            return found._replace(leader=None)
        return found

    def _coming(
        self, meeting: JunctionConflicts, around: NearbyObjects
    ) -> list[tuple[ConflictPath, ConflictingVehicle]]:
        """See `JunctionYield`; with those who ride beside the lanes."""
        riders = [] if self._line is None else crossing_riders(self._line, meeting, around)
        return super()._coming(meeting, around) + riders

    def _gone(self, meeting: JunctionConflicts, found: PredictedConflict, front: float, speed: float) -> YieldDecision:
        """See `JunctionYield`; an ego that would meet someone stops before the next way that it has not entered yet."""
        usual = super()._gone(meeting, found, front, speed)
        if usual.wait_m is not None or not found.met:
            return usual
        limit = min((way.route_meets_s for way in found.met if way.route_meets_s > front), default=front)
        places = {way.route_meets_s for way in meeting.ways if front < way.route_meets_s <= limit}
        rooms = [place - front for place in places if self._enters_nothing(meeting, front, place)]
        room = max((item for item in rooms if can_stop(speed, item, FULL_MPS2)), default=None)
        return usual if room is None else YieldDecision(room, frozenset())

    def _enters_nothing(self, meeting: JunctionConflicts, front: float, place: float) -> bool:
        """True if it would stop before `place` without standing in a priority way that it is not in already."""
        new = [way for way in meeting.ways if way.goes_first and way.route_meets_s > front]
        return not any(way.route_meets_s < place - _SAME_PLACE_M for way in new)

    def _lag_s(self) -> float:
        """None for an ego that has set off: otherwise it would seem too late at every look, and stop again."""
        return 0.0 if self.going else super()._lag_s()

    def _top_mps(self, motion: EgoSpeeds, coming: Sequence[tuple[ConflictPath, ConflictingVehicle]]) -> float:
        pace = flow_speed_mps(coming)
        self.judged = frozenset(item.actor_id for _, item in coming)
        self.flow_mps = min(pace, FASTEST_MPS) if math.isfinite(pace) else 0.0
        return self.flow_mps or motion.top_mps
