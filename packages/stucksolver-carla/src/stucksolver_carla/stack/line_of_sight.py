"""Computes sight distances of lanes: straight lines of sight above the road's ground, without tall objects."""

from __future__ import annotations

import numpy as np
import shapely

from stucksolver.scene import LaneDirection, LaneKind, LaneSight, LaneStrip
from stucksolver.scene.frenet import RoadFrame
from stucksolver.scene.objects import TrackedObject
from stucksolver.scene.surroundings import EgoState

SENSOR_HEIGHT_M = 2.0
"""Minimum height of an object that occludes the road (m). The roof sensors, about 2.5 m up as Bench2Drive's LiDAR, see
over lower ones."""
VERGE_M = 4.0
"""Width of open ground that is assumed next to the outermost lane (m). Beyond it may be a building or a hedge. Ours."""
STEP_M = 4.0
"""Distance between two samples of a lane (m). Ours."""
BEHIND_SAMPLES_M = np.concatenate([np.arange(0.0, 16.0), np.arange(16.0, 1000.0, STEP_M)])
"""Samples behind the ego (m). They are one meter apart near it, where the length limits backing up. Ours."""


class SightLines:
    """Lines of sight on one road geometry."""

    def __init__(self, frame: RoadFrame, range_m: float) -> None:
        self._frame = frame
        self._range_m = range_m
        self._ground = _ground(frame)
        shapely.prepare(self._ground)

    def of_lanes(self, ego: EgoState, ego_s: float, objects: tuple[TrackedObject, ...]) -> tuple[LaneSight, ...]:
        """Return the uninterrupted sight distances ahead and behind, for each lane or roadside strip next to the ego.

        Oncoming lanes that start farther ahead are included: their sight distance counts from the ego, through the
        junction in between.
        """
        tall_objects = [_footprint(o) for o in objects if o.height_m > SENSOR_HEIGHT_M]
        blockers = shapely.union_all(tall_objects) if tall_objects else None
        sights = []
        for lane in self._frame.lanes:
            begins_ahead = lane.strip.direction is LaneDirection.OPPOSITE and lane.start_m < ego_s + self._range_m
            begins_m = ego_s if begins_ahead else lane.start_m - 2.0
            if not is_sight_lane(lane.strip) or not begins_m <= ego_s <= lane.end_m + 2.0:
                continue
            ahead = np.arange(ego_s, min(lane.end_m, ego_s + self._range_m), STEP_M)
            behind = ego_s - BEHIND_SAMPLES_M[ego_s - max(lane.start_m, ego_s - self._range_m) > BEHIND_SAMPLES_M]
            lengths = []
            for stations in (ahead, behind):
                center_m = np.interp(stations, lane.s, lane.center)
                lengths.append(self._visible_length_m(ego, stations, center_m, blockers))
            sights.append(LaneSight(lane_id=lane.strip.id, ahead_m=lengths[0], behind_m=lengths[1]))
        return tuple(sights)

    def _visible_length_m(
        self, ego: EgoState, stations: np.ndarray, offsets: np.ndarray, blockers: shapely.Geometry | None
    ) -> float:
        if len(stations) < 2:
            return 0.0
        x, y, _ = self._frame.to_local(stations, offsets)
        rays = np.empty((len(x), 2, 2))
        rays[:, 0] = (ego.x_m, ego.y_m)
        rays[:, 1, 0], rays[:, 1, 1] = x, y
        lines = shapely.linestrings(rays)
        is_free = shapely.covers(self._ground, lines)
        if blockers is not None:
            is_free &= ~shapely.intersects(blockers, lines)
        # The first samples are under the ego itself.
        tall_objects = np.flatnonzero(~is_free[1:])
        last = int(tall_objects[0]) if len(tall_objects) else len(stations) - 1
        return round(float(abs(stations[last] - stations[0])), 1)


def is_sight_lane(strip: LaneStrip) -> bool:
    """Return True for strips whose sight distance is used: driving lanes, and roadside strips for a stop of the ego."""
    is_roadside = strip.kind in (LaneKind.PARKING, LaneKind.SHOULDER) and strip.direction is not LaneDirection.OPPOSITE
    return strip.kind is LaneKind.DRIVING or is_roadside


def _ground(frame: RoadFrame) -> shapely.Geometry:
    """Return the road with its roadside strips and a verge as one area."""
    areas = []
    for lane in frame.lanes:
        if len(lane.s) < 2:
            continue
        left = np.stack(frame.to_local(lane.s, lane.left + VERGE_M)[:2], axis=1)
        right = np.stack(frame.to_local(lane.s, lane.right - VERGE_M)[:2], axis=1)
        areas.append(shapely.polygons(np.concatenate([left, right[::-1]])))
    return shapely.union_all(shapely.make_valid(np.array(areas)))


def _footprint(obj: TrackedObject) -> shapely.Geometry:
    c, n = np.cos(obj.yaw_rad), np.sin(obj.yaw_rad)
    half_l, half_w = obj.length_m / 2, obj.width_m / 2
    corners = [(half_l, half_w), (half_l, -half_w), (-half_l, -half_w), (-half_l, half_w)]
    return shapely.polygons([(obj.x_m + a * c - b * n, obj.y_m + a * n + b * c) for a, b in corners])
