"""Moving vehicles follow their lane unless they are seen to leave it.

A LiDAR measures a course poorly from afar: at 60 m, a speed across the lane of 0.3 m/s is usual noise, but over five
seconds it would lead from one lane into the next. So a speed across the lane that is within the noise counts as zero,
and the vehicle points along its lane. A larger one is reported as it was measured, and so is everything in junctions,
where lanes overlap, beside lanes, on foot, or slow.
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

KEEPS_SD_M = 0.4
"""Standard deviation across its lane of a vehicle that was seen to follow it and is hidden for a moment: with twice
this on either side, a car fills a usual lane. Otherwise, a car that has passed and is hidden is soon as wide as two.
"""
SURE_SDS = 2.0
ACROSS_MPS = 0.15
"""Standard deviation of a track's speed across its lane next to the ego, ..."""
ACROSS_FARTHER = 0.006
"""... and what each meter of distance adds (m/s): the errors of moving cars in recordings of seven drives, with some
reserve.
"""
SETTLED_MPS = 1.0
"""Until the tracker knows a new track's speed across the lane this well, its own standard deviation is used."""
SLOW_MPS = 1.5
"""A slower vehicle may be maneuvering."""


class OnLanes:
    """The tracks of one map. `told` caches its last answer, since it is called several times per percept."""

    def __init__(self, carla_map: carla.Map) -> None:
        self._map = carla_map
        self._last: tuple[PerceptionResult | None, tuple[Track, ...]] = (None, ())

    def told(self, percept: PerceptionResult | None) -> tuple[Track, ...]:
        """Return a percept's tracks with the courses of their lanes."""
        if percept is not self._last[0]:
            tracks = () if percept is None else percept.tracks
            self._last = (
                percept,
                tuple(on_lane(track, self._map, percept.pose) for track in tracks) if percept else (),
            )
        return self._last[1]


def on_lane(track: Track, carla_map: Any, ego: Any) -> Track:
    """Return a track with the course of its lane, or unchanged. `ego` has `x_m`, `y_m` and `z_m`, local frame."""
    if not WHEELED[track.label] or math.hypot(track.vx_mps, track.vy_mps) < SLOW_MPS:
        return track
    waypoint = carla_map.get_waypoint(carla.Location(*to_world(track.x_m, track.y_m), ego.z_m))
    if waypoint is None or waypoint.is_junction:
        return track
    x, y = to_local(waypoint.transform.location)
    yaw = yaw_to_local(waypoint.transform.rotation.yaw)
    cos, sin = math.cos(yaw), math.sin(yaw)
    along, across = track.vx_mps * cos + track.vy_mps * sin, track.vy_mps * cos - track.vx_mps * sin
    beside = abs((track.y_m - y) * cos - (track.x_m - x) * sin)
    away = math.hypot(track.x_m - ego.x_m, track.y_m - ego.y_m)
    if beside > waypoint.lane_width / 2.0 or abs(across) > SURE_SDS * _across_sd_mps(track, yaw, away):
        return track
    turned = yaw if along >= 0.0 else math.remainder(yaw + math.pi, math.tau)
    covariance = _kept_in_lane(track.covariance, yaw) if track.hidden else track.covariance
    return replace(track, yaw_rad=turned, vx_mps=along * cos, vy_mps=along * sin, covariance=covariance)


def _kept_in_lane(covariance: Floats, yaw_rad: float) -> Floats:
    """(5, 5): the same covariance, with at most `KEEPS_SD_M` across a lane of this direction."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    turn = np.array([[cos, sin], [-sin, cos]])
    placed = turn @ covariance[:2, :2] @ turn.T
    if placed[1, 1] <= KEEPS_SD_M**2:
        return covariance
    kept: Floats = covariance.copy()
    kept[:2, :2] = turn.T @ np.diag([placed[0, 0], KEEPS_SD_M**2]) @ turn
    kept[:2, 2:] = kept[2:, :2] = 0.0
    return kept


def _across_sd_mps(track: Track, yaw_rad: float, away_m: float) -> float:
    """Return the standard deviation of a track's speed across a lane of this direction (m/s)."""
    side = np.array([-math.sin(yaw_rad), math.cos(yaw_rad)])
    filtered = math.sqrt(max(float(side @ track.covariance[3:, 3:] @ side), 0.0))
    return filtered if filtered > SETTLED_MPS else ACROSS_MPS + ACROSS_FARTHER * away_m
