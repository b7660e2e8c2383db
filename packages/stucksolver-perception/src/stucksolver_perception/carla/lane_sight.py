"""Computes the sight distances of lanes from sensors: the LiDAR's free space, and beyond it ahead the camera's.

The LiDAR comes first. If its sight along a lane ends because no ray came back from the ground, the camera continues, as
far as its detector would have found a vehicle (`stucksolver_perception/far_view.py`). The camera is not used in a
direction in which a tall object without a track is nearer, because the object would occlude both sensors. The boxes of
tracked objects determine what they hide from the camera, which is lower (`camera_sight_distance.CameraSight`). There is
no far sight behind.

A stretch that was free recently is still free, except for traffic that may have entered from beyond its end at the
speed of the lane's vehicles. (Traffic from the side is a tracked object.) So a passing car, or lost points of one turn,
do not end a plan.
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
"""Distance between two points of a lane (m). Ours."""
RANGE_M = 200.0
"""Maximum sight distance (m). Ours."""
FASTEST_SHARE = 1.2
"""Maximum speed of other traffic as a share of the lane's limit. The guard's margins assume the limit; the sight
distance covers faster traffic too. Ours."""
UNKNOWN_LIMIT_MPS = 100.0 / 3.6
"""Speed limit of a lane without one on the map (m/s): that of rural roads."""
MEMORY_S = 1.0
"""Time after which a lane without a new result is unknown (s). Ours."""


class _FreeInterval(NamedTuple):
    """One lane in one result: the arc lengths between which it was free (m)."""

    time_s: float
    end_s: float
    start_s: float


class SensorLaneSight:
    """Sight distances from sensors, with the interface of `stucksolver_carla.stack.line_of_sight.SightLines`."""

    def __init__(self, perception: EgoPerception, frame: RoadFrame) -> None:
        self._perception, self._frame = perception, frame
        self._recent_intervals: dict[str, deque[_FreeInterval]] = {}
        """The recent free intervals of each lane, oldest first."""

    def of_lanes(self, ego: EgoState, ego_s: float, objects: tuple[TrackedObject, ...]) -> tuple[LaneSight, ...]:
        """Return the uninterrupted sight distances ahead and behind for each strip of the road next to the ego."""
        percept = self._perception.percept
        if percept is None:
            return ()
        sights = []
        known = _moving_footprints(percept)
        for lane in self._frame.lanes:
            if not is_sight_lane(lane.strip) or not lane.start_m - 2.0 <= ego_s <= lane.end_m + 2.0:
                continue
            ahead = self._line(lane, np.arange(ego_s, min(lane.end_m, ego_s + RANGE_M), STEP_M))
            behind = self._line(lane, np.arange(ego_s, max(lane.start_m, ego_s - RANGE_M), -STEP_M))
            fastest_mps = FASTEST_SHARE * (lane.strip.speed_limit_mps or UNKNOWN_LIMIT_MPS)
            ahead_m = visible_ahead_m(percept, ahead, fastest_mps)
            behind_m = percept.seen.free_length_along_m(points_into_vehicle(behind, percept.pose), known=known)
            now = _FreeInterval(percept.pose.time_s, ego_s + ahead_m, ego_s - behind_m)
            end_s, start_s = self._still_free(lane.strip.id, now, fastest_mps)
            lengths = (round(max(end_s - ego_s, 0.0), 1), round(max(ego_s - start_s, 0.0), 1))
            sights.append(LaneSight(lane_id=lane.strip.id, ahead_m=lengths[0], behind_m=lengths[1]))
        return tuple(sights)

    def _still_free(self, lane_id: str, now: _FreeInterval, fastest_mps: float) -> tuple[float, float]:
        """Return the arc lengths up to which the lane is free, ahead and behind, with the recent results."""
        intervals = self._recent_intervals.setdefault(lane_id, deque())
        intervals.append(now)
        while intervals[0].time_s < now.time_s - MEMORY_S:
            intervals.popleft()
        travel_m = [fastest_mps * (now.time_s - item.time_s) for item in intervals]
        ahead = max(item.end_s - travel for item, travel in zip(intervals, travel_m, strict=True))
        behind = min(item.start_s + travel for item, travel in zip(intervals, travel_m, strict=True))
        return ahead, behind

    def _line(self, lane: Lane, stations: Floats) -> Floats:
        """Return (k, 2): positions of the lane's center in the local frame."""
        x, y, _ = self._frame.to_local(stations, np.interp(stations, lane.s, lane.center))
        return np.stack([x, y], axis=1)


def _moving_footprints(percept: PerceptionResult) -> Floats:
    """Return (n, 5): the footprints of moving objects, which do not end sight: the guard checks each of them itself."""
    moving = (track for track in percept.tracks if track.standing_since_s is None and not track.hidden)
    return footprints(boxes_of(moving, percept.pose))


def visible_ahead_m(percept: PerceptionResult, line: Floats, fastest_mps: float) -> float:
    """Return the length of a lane without any vehicle, from the present result (m).

    The line is the lane's center (k, 2) in the local frame, starting next to the ego. `fastest_mps` is the highest
    speed in the lane.
    """
    if len(line) < 2:
        return 0.0
    course = points_into_vehicle(line, percept.pose)
    lidar_m = percept.seen.free_length_along_m(course)
    if percept.far_view is None:
        return lidar_m
    combined_m = percept.far_view.clear_length_m(line, lidar_m, fastest_mps, percept.pose.time_s)
    blocked_m = percept.seen.blocked_m if percept.unknown_m is None else percept.unknown_m
    return max(lidar_m, min(combined_m, free_length_m(percept.seen, blocked_m, course, lidar_m)))


def free_length_m(free_space: FreeSpace, blocked_m: Floats, course: Floats, from_m: float) -> float:
    """Return the length of a line (k, 2; vehicle frame) up to the first point behind a tall object (m).

    `blocked_m` (AZIMUTHS,) has the distances of tall objects by direction. Only points beyond `from_m` count. A point
    in the same bin of directions as a tall object counts as behind it.
    """
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(course, axis=0).T))])
    dx, dy = course[:, 0] - free_space.origin[0], course[:, 1] - free_space.origin[1]
    bins = ((np.arctan2(dy, dx) + math.pi) / math.tau * AZIMUTHS).astype(np.int64) % AZIMUTHS
    is_behind = (blocked_m[bins] <= np.hypot(dx, dy)) & (along > from_m)
    return float(along[max(int(is_behind.argmax()) - 1, 0)]) if is_behind.any() else float(along[-1])
