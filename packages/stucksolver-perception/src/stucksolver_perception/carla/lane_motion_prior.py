"""Assumes that moving vehicles follow their lane, unless their measured speed across it is above the noise.

A LiDAR measures a far course poorly. At 60 m, a speed across the lane of 0.3 m/s is usual noise, but over five seconds
it would lead from one lane into the next. So a speed across the lane that is within the noise counts as zero, and the
vehicle points along its lane. A larger speed is reported as measured. The same holds for objects in junctions, where
lanes overlap, for objects next to lanes, for pedestrians, and for slow objects.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import carla
import numpy as np

from stucksolver_carla.stack.carla_frames import to_local, to_world, yaw_to_local
from stucksolver_perception.cycle_data import PerceptionResult
from stucksolver_perception.measurements import Floats
from stucksolver_perception.tracking import Track
from stucksolver_perception.tracking.motion_groups import WHEELED

LATERAL_SD_M = 0.4
"""Maximum standard deviation across the lane of an occluded vehicle that followed its lane (m). With twice this on
either side, a car fills a usual lane. Without the limit, an occluded car would soon be as wide as two."""
NOISE_SDS = 2.0
"""Number of standard deviations within which a speed across the lane counts as noise. Ours."""
ACROSS_SD_MPS = 0.15
"""Standard deviation of a track's speed across its lane next to the ego (m/s).

The value and `ACROSS_SD_PER_M` are the errors of moving cars in recordings of seven drives, with a reserve."""
ACROSS_SD_PER_M = 0.006
"""Increase of that standard deviation per meter of distance (m/s)."""
SETTLED_MPS = 1.0
"""Standard deviation of the tracker's speed across the lane above which the tracker's own value is used (m/s), because
the track is new. Ours."""
SLOW_MPS = 1.5
"""Minimum speed (m/s); a slower vehicle may be maneuvering. Ours."""


class LaneMotionPrior:
    """The prior on one map. The last result is cached, because it is requested several times per perception result."""

    def __init__(self, carla_map: carla.Map) -> None:
        self._map = carla_map
        self._last: tuple[PerceptionResult | None, tuple[Track, ...]] = (None, ())

    def with_lane_courses(self, percept: PerceptionResult | None) -> tuple[Track, ...]:
        """Return the tracks of a perception result with the courses of their lanes."""
        if percept is not self._last[0]:
            tracks = () if percept is None else percept.tracks
            self._last = (
                percept,
                tuple(with_lane_course(track, self._map, percept.pose) for track in tracks) if percept else (),
            )
        return self._last[1]


def with_lane_course(track: Track, carla_map: Any, ego: Any) -> Track:
    """Return a track with the course of its lane, or unchanged. `ego` has `x_m`, `y_m` and `z_m` in the local frame."""
    if not WHEELED[track.label] or math.hypot(track.vx_mps, track.vy_mps) < SLOW_MPS:
        return track
    waypoint = carla_map.get_waypoint(carla.Location(*to_world(track.x_m, track.y_m), ego.z_m))
    if waypoint is None or waypoint.is_junction:
        return track
    x, y = to_local(waypoint.transform.location)
    yaw = yaw_to_local(waypoint.transform.rotation.yaw)
    cos, sin = math.cos(yaw), math.sin(yaw)
    along, across = track.vx_mps * cos + track.vy_mps * sin, track.vy_mps * cos - track.vx_mps * sin
    lateral_m = abs((track.y_m - y) * cos - (track.x_m - x) * sin)
    distance_m = math.hypot(track.x_m - ego.x_m, track.y_m - ego.y_m)
    if lateral_m > waypoint.lane_width / 2.0 or abs(across) > NOISE_SDS * _across_sd_mps(track, yaw, distance_m):
        return track
    lane_yaw = yaw if along >= 0.0 else math.remainder(yaw + math.pi, math.tau)
    covariance = _limited_to_lane(track.covariance, yaw) if track.hidden else track.covariance
    return replace(track, yaw_rad=lane_yaw, vx_mps=along * cos, vy_mps=along * sin, covariance=covariance)


def _limited_to_lane(covariance: Floats, yaw_rad: float) -> Floats:
    """Return (5, 5): the covariance, with a standard deviation of at most `LATERAL_SD_M` across a lane's direction."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    turn = np.array([[cos, sin], [-sin, cos]])
    lane_covariance = turn @ covariance[:2, :2] @ turn.T
    if lane_covariance[1, 1] <= LATERAL_SD_M**2:
        return covariance
    limited: Floats = covariance.copy()
    limited[:2, :2] = turn.T @ np.diag([lane_covariance[0, 0], LATERAL_SD_M**2]) @ turn
    limited[:2, 2:] = limited[2:, :2] = 0.0
    return limited


def _across_sd_mps(track: Track, yaw_rad: float, away_m: float) -> float:
    """Return the standard deviation of a track's speed across a lane of this direction (m/s)."""
    side = np.array([-math.sin(yaw_rad), math.cos(yaw_rad)])
    filtered = math.sqrt(max(float(side @ track.covariance[3:, 3:] @ side), 0.0))
    return filtered if filtered > SETTLED_MPS else ACROSS_SD_MPS + ACROSS_SD_PER_M * away_m
