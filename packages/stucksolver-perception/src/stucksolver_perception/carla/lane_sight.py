"""How far the sensors see lanes: the LiDAR's free space, and beyond it ahead the camera's.

The LiDAR comes first. If its sight along a lane ends because no ray came back from the ground, the camera continues, as
far as its detector would have found a vehicle (`stucksolver_perception/far_view.py`). If something tall that nobody
tracks is nearer in the direction of a place, the camera is not used: both would have to see past the same thing. What
a tracked object hides from the camera, which is lower, its boxes tell (`far_sight.CameraSight`). There is no camera
behind.

A stretch seen a moment ago is still free, except for traffic that may have entered from beyond its end at the speed of
the lane's vehicles. (Traffic from the side is a tracked object.) So a passing car, or lost points of one turn, do not
end a plan.
"""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stucksolver.scene import LaneSight
from stucksolver.scene.frenet import Lane, RoadFrame
from stucksolver.scene.objects import TrackedObject
from stucksolver.scene.surroundings import EgoState
from stucksolver_carla.stack.line_of_sight import is_sight_lane
from stucksolver_perception.cycle_data import PerceptionResult
from stucksolver_perception.free_space import AZIMUTHS, FreeSpace, footprints
from stucksolver_perception.measurements import Floats
from stucksolver_perception.tracking import boxes_of
from stucksolver_perception.vehicle_frame import points_into_vehicle

if TYPE_CHECKING:
    from stucksolver_perception.carla.ego_perception import EgoPerception

STEP_M = 1.0
RANGE_M = 200.0
FASTEST_SHARE = 1.2
"""Others drive up to this share of the lane's limit: the guard's margins assume the limit, sight covers everybody."""
UNKNOWN_LIMIT_MPS = 100.0 / 3.6
"""Used if the map has no limit: that of country roads."""
REMEMBERED_S = 1.0
"""A lane that was not seen for longer is unknown."""


class _FreeInterval(NamedTuple):
    """One lane as seen at one moment: the arc lengths between which it was free (m)."""

    time_s: float
    end_s: float
    start_s: float


class SensorLaneSight:
    """See `carla_stack.sight.SightLines`: the same question, answered from the sensors."""

    def __init__(self, eyes: EgoPerception, frame: RoadFrame) -> None:
        self._eyes, self._frame = eyes, frame
        self._known: dict[str, deque[_FreeInterval]] = {}
        """What was seen of each lane recently, oldest first."""

    def of_lanes(self, ego: EgoState, ego_s: float, objects: tuple[TrackedObject, ...]) -> tuple[LaneSight, ...]:
        """Return, for each lane or roadside strip beside the ego, the length seen without a break, ahead and behind."""
        percept = self._eyes.percept
        if percept is None:
            return ()
        found = []
        known = _moving(percept)
        for lane in self._frame.lanes:
            if not is_sight_lane(lane.strip) or not lane.start_m - 2.0 <= ego_s <= lane.end_m + 2.0:
                continue
            ahead = self._line(lane, np.arange(ego_s, min(lane.end_m, ego_s + RANGE_M), STEP_M))
            behind = self._line(lane, np.arange(ego_s, max(lane.start_m, ego_s - RANGE_M), -STEP_M))
            fastest_mps = FASTEST_SHARE * (lane.strip.speed_limit_mps or UNKNOWN_LIMIT_MPS)
            seen_m = visible_ahead_m(percept, ahead, fastest_mps)
            back_m = percept.seen.free_length_along_m(points_into_vehicle(behind, percept.pose), known=known)
            now = _FreeInterval(percept.pose.time_s, ego_s + seen_m, ego_s - back_m)
            end_s, start_s = self._remembered(lane.strip.id, now, fastest_mps)
            told = (round(max(end_s - ego_s, 0.0), 1), round(max(ego_s - start_s, 0.0), 1))
            found.append(LaneSight(lane_id=lane.strip.id, ahead_m=told[0], behind_m=told[1]))
        return tuple(found)

    def _remembered(self, lane_id: str, now: _FreeInterval, fastest_mps: float) -> tuple[float, float]:
        """Return the arc lengths up to which the lane is known to be free, ahead and behind."""
        known = self._known.setdefault(lane_id, deque())
        known.append(now)
        while known[0].time_s < now.time_s - REMEMBERED_S:
            known.popleft()
        came_m = [fastest_mps * (now.time_s - item.time_s) for item in known]
        ahead = max(item.end_s - gone for item, gone in zip(known, came_m, strict=True))
        behind = min(item.start_s + gone for item, gone in zip(known, came_m, strict=True))
        return ahead, behind

    def _line(self, lane: Lane, stations: Floats) -> Floats:
        """(k, 2): positions of the lane's center in the local frame."""
        x, y, _ = self._frame.to_local(stations, np.interp(stations, lane.s, lane.centre))
        return np.stack([x, y], axis=1)


def _moving(percept: PerceptionResult) -> Floats:
    """(n, 5): moving vehicles as `FreeSpace.seen_along` takes them: the guard looks at each of them by itself."""
    moving = (track for track in percept.tracks if track.standing_since_s is None and not track.hidden)
    return footprints(boxes_of(moving, percept.pose))


def visible_ahead_m(percept: PerceptionResult, line: Floats, fastest_mps: float) -> float:
    """Return the meters of a lane in which nobody is, as seen now.

    The line is the lane's center (k, 2) in the local frame, from beside the ego on. `fastest_mps` is the highest speed
    in it.
    """
    if len(line) < 2:
        return 0.0
    course = points_into_vehicle(line, percept.pose)
    by_lidar_m = percept.seen.free_length_along_m(course)
    if percept.far_view is None:
        return by_lidar_m
    by_both_m = percept.far_view.clear_length_m(line, by_lidar_m, fastest_mps, percept.pose.time_s)
    blocked_m = percept.seen.blocked_m if percept.unknown_m is None else percept.unknown_m
    return max(by_lidar_m, min(by_both_m, free_length_m(percept.seen, blocked_m, course, by_lidar_m)))


def free_length_m(seen: FreeSpace, blocked_m: Floats, course: Floats, from_m: float) -> float:
    """Return the meters of a line (k, 2; vehicle frame) up to where the LiDAR found something tall that is nearer.

    `blocked_m` (AZIMUTHS,) says how near, by direction. Only beyond `from_m`. What lies in one bin of directions with
    something tall counts as behind it.
    """
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(course, axis=0).T))])
    dx, dy = course[:, 0] - seen.origin[0], course[:, 1] - seen.origin[1]
    bins = ((np.arctan2(dy, dx) + math.pi) / math.tau * AZIMUTHS).astype(np.int64) % AZIMUTHS
    behind = (blocked_m[bins] <= np.hypot(dx, dy)) & (along > from_m)
    return float(along[max(int(behind.argmax()) - 1, 0)]) if behind.any() else float(along[-1])
