"""How far lanes are seen: straight lines of sight that stay above the road's own ground and pass no tall object."""

from __future__ import annotations

import numpy as np
import shapely

from stucksolver.scene import LaneDirection, LaneKind, LaneSight, LaneStrip
from stucksolver.scene.frenet import RoadFrame
from stucksolver.scene.objects import TrackedObject
from stucksolver.scene.surroundings import EgoState

SENSOR_HEIGHT_M = 2.0
"""Objects lower than the roof sensors (about 2.5 m up, as Bench2Drive's LiDAR) do not hide the road behind them."""
VERGE_M = 4.0
"""Open ground assumed beside the outermost lane; beyond it may be a building or a hedge."""
STEP_M = 4.0
BEHIND_M = np.concatenate([np.arange(0.0, 16.0), np.arange(16.0, 1000.0, STEP_M)])
"""Where to look behind: nearby, because every meter counts for backing up."""


class SightLines:
    """Lines of sight on one road geometry."""

    def __init__(self, frame: RoadFrame, range_m: float) -> None:
        self._frame = frame
        self._range_m = range_m
        self._ground = _ground(frame)
        shapely.prepare(self._ground)

    def of_lanes(self, ego: EgoState, ego_s: float, objects: tuple[TrackedObject, ...]) -> tuple[LaneSight, ...]:
        """Return, for each lane or roadside strip beside the ego, the length seen without a break, ahead and behind.

        This includes oncoming lanes that begin further on: seen along their line from here, through the junction
        between.
        """
        hidden = [_footprint(o) for o in objects if o.height_m > SENSOR_HEIGHT_M]
        blocking = shapely.union_all(hidden) if hidden else None
        found = []
        for lane in self._frame.lanes:
            further_on = lane.strip.direction is LaneDirection.OPPOSITE and lane.start_m < ego_s + self._range_m
            begins_m = ego_s if further_on else lane.start_m - 2.0
            if not may_stand_in(lane.strip) or not begins_m <= ego_s <= lane.end_m + 2.0:
                continue
            ahead = np.arange(ego_s, min(lane.end_m, ego_s + self._range_m), STEP_M)
            behind = ego_s - BEHIND_M[ego_s - max(lane.start_m, ego_s - self._range_m) > BEHIND_M]
            seen = []
            for stations in (ahead, behind):
                centre = np.interp(stations, lane.s, lane.centre)
                seen.append(self._unbroken(ego, stations, centre, blocking))
            found.append(LaneSight(lane_id=lane.strip.id, ahead_m=seen[0], behind_m=seen[1]))
        return tuple(found)

    def _unbroken(
        self, ego: EgoState, stations: np.ndarray, offsets: np.ndarray, blocking: shapely.Geometry | None
    ) -> float:
        if len(stations) < 2:
            return 0.0
        x, y, _ = self._frame.to_local(stations, offsets)
        rays = np.empty((len(x), 2, 2))
        rays[:, 0] = (ego.x_m, ego.y_m)
        rays[:, 1, 0], rays[:, 1, 1] = x, y
        lines = shapely.linestrings(rays)
        free = shapely.covers(self._ground, lines)
        if blocking is not None:
            free &= ~shapely.intersects(blocking, lines)
        # The first samples are under the ego itself.
        hidden = np.flatnonzero(~free[1:])
        last = int(hidden[0]) if len(hidden) else len(stations) - 1
        return round(float(abs(stations[last] - stations[0])), 1)


def may_stand_in(strip: LaneStrip) -> bool:
    """True for driving lanes, and for the strips beside them on which the ego may stand: the sight of these counts."""
    beside = strip.kind in (LaneKind.PARKING, LaneKind.SHOULDER) and strip.direction is not LaneDirection.OPPOSITE
    return strip.kind is LaneKind.DRIVING or beside


def _ground(frame: RoadFrame) -> shapely.Geometry:
    """Return the road with everything beside it that belongs to it, and a verge, as one area."""
    areas = []
    for lane in frame.lanes:
        if len(lane.s) < 2:
            continue
        left = np.stack(frame.to_local(lane.s, lane.left + VERGE_M)[:2], axis=1)
        right = np.stack(frame.to_local(lane.s, lane.right - VERGE_M)[:2], axis=1)
        areas.append(shapely.polygons(np.concatenate([left, right[::-1]])))
    return shapely.union_all(shapely.make_valid(np.array(areas)))


def _footprint(thing: TrackedObject) -> shapely.Geometry:
    c, n = np.cos(thing.yaw_rad), np.sin(thing.yaw_rad)
    half_l, half_w = thing.length_m / 2, thing.width_m / 2
    corners = [(half_l, half_w), (half_l, -half_w), (-half_l, -half_w), (-half_l, half_w)]
    return shapely.polygons([(thing.x_m + a * c - b * n, thing.y_m + a * n + b * c) for a, b in corners])
