"""How far lanes are seen by the sensors: the LiDAR's free space, and ahead of it the camera's."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stucksolver.perception.frames import points_into_vehicle
from stucksolver.scene import LaneKind, LaneSight
from stucksolver.scene.frenet import Lane, RoadFrame
from stucksolver.scene.objects import TrackedObject
from stucksolver.scene.surroundings import EgoState

if TYPE_CHECKING:
    from stucksolver.stacks.sensed.eyes import Eyes

STEP_M = 1.0
RANGE_M = 200.0


class SensedSight:
    """See `carla_stack.sight.SightLines`: the same question, answered by what the sensors saw."""

    def __init__(self, eyes: Eyes, frame: RoadFrame) -> None:
        self._eyes, self._frame = eyes, frame

    def of_lanes(self, ego: EgoState, ego_s: float, objects: tuple[TrackedObject, ...]) -> tuple[LaneSight, ...]:
        """For each driving lane beside the ego: the length seen without a break, ahead and behind."""
        percept = self._eyes.percept
        if percept is None:
            return ()
        found = []
        for lane in self._frame.lanes:
            if lane.strip.kind is not LaneKind.DRIVING or not lane.start_m - 2.0 <= ego_s <= lane.end_m + 2.0:
                continue
            ahead = self._line(lane, np.arange(ego_s, min(lane.end_m, ego_s + RANGE_M), STEP_M))
            behind = self._line(lane, np.arange(ego_s, max(lane.start_m, ego_s - RANGE_M), -STEP_M))
            seen_m = percept.seen.seen_along(ahead) if len(ahead) > 1 else 0.0
            back_m = percept.seen.seen_along(behind) if len(behind) > 1 else 0.0
            found.append(LaneSight(lane_id=lane.strip.id, ahead_m=round(seen_m, 1), behind_m=round(back_m, 1)))
        return tuple(found)

    def _line(self, lane: Lane, stations: np.ndarray) -> np.ndarray:
        """(k, 2) places of the lane's centre in the vehicle frame of the newest result."""
        percept = self._eyes.percept
        assert percept is not None
        x, y, _ = self._frame.to_local(stations, np.interp(stations, lane.s, lane.centre))
        return points_into_vehicle(np.stack([x, y], axis=1), percept.pose)
