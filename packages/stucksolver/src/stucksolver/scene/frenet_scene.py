"""Surroundings of one tick in road coordinates, for behaviors and the guard."""

from __future__ import annotations

import math
from collections.abc import Hashable
from functools import cached_property
from typing import Any

import numpy as np

from stucksolver.scene.frenet import Array, Lane, Mask, RoadFrame, road_frame, wrap_angle
from stucksolver.scene.objects import ON_FOOT, STATIC_KINDS, TWO_WHEELED, VULNERABLE, TrackedObject
from stucksolver.scene.reverse_frame import backwards
from stucksolver.scene.road import LaneDirection, LaneKind, Zone, ZoneKind
from stucksolver.scene.surroundings import Surroundings

ACROSS_SIN = math.sin(math.radians(20.0))
"""Sine of the angle to the road from which a vehicle counts as driving across it. Ours."""
HEADS_MPS = 1.0
"""Speed above which the direction of motion is more reliable than the heading (m/s). Ours."""
MOVING_MPS = 0.1
"""Speed above which an object counts as moving (m/s), as for `TrackedObject.stationary_s`."""
SURE_SDS = 2.0
"""Boxes grow on each side by this many standard deviations of their position: 95 % of a normal error."""


class FrenetScene:
    """Objects and ego in road coordinates. Arrays have shape (objects,), in the order of `objects`.

    Attributes:
        places: Box centers (x, y) in the local frame (m); shape (objects, 2).
        s, d: Box centers (m).
        yaw: Heading relative to the road (rad).
        vs, vd: Velocity along and across the road (m/s).
        half_length, half_width: Half size of the boxes, enlarged by the uncertainty of perception (m).
        along, across: Half extents of these boxes along and across the road (m).
    """

    def __init__(self, surroundings: Surroundings) -> None:
        self.surroundings = surroundings
        self.frame: RoadFrame = road_frame(surroundings.road)
        self.objects: tuple[TrackedObject, ...] = surroundings.objects
        ego = surroundings.ego
        self.ego = ego
        everyone = np.array(
            [(ego.x_m, ego.y_m, ego.yaw_rad, 0.0, 0.0, ego.length_m, ego.width_m)]
            + [(o.x_m, o.y_m, o.yaw_rad, o.vx_mps, o.vy_mps, o.length_m, o.width_m) for o in surroundings.objects]
        )
        self.places: Array = everyone[1:, :2]
        s, d, heading = self.frame.to_road(everyone[:, :2])
        yaw = wrap_angle(everyone[:, 2] - heading)
        self.ego_s, self.ego_d, self.ego_yaw = float(s[0]), float(d[0]), float(yaw[0])
        self.s, self.d, self.yaw = s[1:], d[1:], yaw[1:]
        cos, sin = np.cos(heading[1:]), np.sin(heading[1:])
        vx, vy = everyone[1:, 3], everyone[1:, 4]
        self.vs, self.vd = vx * cos + vy * sin, vy * cos - vx * sin
        spread = np.array([_spread_m(o) for o in surroundings.objects]).reshape(-1, 2)
        self.half_length, self.half_width = (everyone[1:, 5:7] / 2 + SURE_SDS * spread).T
        c, n = np.abs(np.cos(self.yaw)), np.abs(np.sin(self.yaw))
        self.along: Array = self.half_length * c + self.half_width * n
        self.across: Array = self.half_length * n + self.half_width * c
        self.uncertainty_m: Array = SURE_SDS * (spread[:, 0] * n + spread[:, 1] * c)
        """(objects,): part of `across` that is due to the uncertainty of the position (m)."""
        self.memo: dict[Hashable, Any] = {}
        """Results that were computed from this tick, by key. They end with it, although they may refer to it."""

    @cached_property
    def backwards(self) -> FrenetScene:
        """The same tick for an ego that backs up along the route: ahead becomes behind, left becomes right."""
        return FrenetScene(backwards(self.surroundings))

    @cached_property
    def on_foot(self) -> Mask:
        """(objects,): True for kinds that may step onto the road."""
        return np.array([o.kind in ON_FOOT for o in self.objects], dtype=bool)

    @cached_property
    def vulnerable(self) -> Mask:
        """(objects,): True for vulnerable road users."""
        return np.array([o.kind in VULNERABLE for o in self.objects], dtype=bool)

    @cached_property
    def two_wheeled(self) -> Mask:
        """(objects,): True for two-wheelers."""
        return np.array([o.kind in TWO_WHEELED for o in self.objects], dtype=bool)

    @cached_property
    def speed(self) -> Array:
        """(objects,): speed in any direction (m/s)."""
        result: Array = np.hypot(self.vs, self.vd)
        return result

    @cached_property
    def moving(self) -> Mask:
        """(objects,): True for moving objects."""
        still = np.array([o.kind in STATIC_KINDS for o in self.objects], dtype=bool)
        result: Mask = (self.speed > MOVING_MPS) & ~still
        return result

    def index_of(self, object_id: str) -> int | None:
        """Return the index of an object in the arrays, or None if it is not currently detected."""
        return next((i for i, o in enumerate(self.objects) if o.id == object_id), None)

    def zone_at(self, s: float, *kinds: ZoneKind) -> Zone | None:
        """Return the zone that the ego's box touches with its center at `s` (m), or None.

        Without `kinds`, zones of all kinds count.
        """
        half = self.ego.length_m / 2
        for zone in self.surroundings.road.zones:
            if zone.start_m < s + half and s - half < zone.end_m and (not kinds or zone.kind in kinds):
                return zone
        return None

    @property
    def ego_front_s(self) -> float:
        """Arc length of the ego's front bumper along the route (m)."""
        return self.ego_s + self.ego.length_m / 2

    @cached_property
    def gap(self) -> Array:
        """Gap along the road from the ego's front bumper to each object's near side (m); negative beside or behind."""
        return self.s - self.along - self.ego_front_s

    @cached_property
    def ego_lane(self) -> Lane | None:
        """Lane that contains the ego's center, if any."""
        return self.frame.lane_at(self.ego_s, self.ego_d)

    @cached_property
    def lane_of(self) -> tuple[Lane | None, ...]:
        """Lane that contains each object's center, if any."""
        return tuple(self.frame.lane_at(float(s), float(d)) for s, d in zip(self.s, self.d, strict=True))

    @cached_property
    def on_lane(self) -> Mask:
        """(objects,): True if the center is on a lane of the route's road."""
        mask = np.zeros(len(self.objects), dtype=bool)
        for lane in self.frame.lanes:
            # Beyond the known stretch of road, its lanes are assumed to continue.
            start = -np.inf if lane.start_m <= self.frame.s[0] else lane.start_m
            end = np.inf if lane.end_m >= self.frame.end_m else lane.end_m
            within = (self.s >= start) & (self.s <= end)
            if within.any():
                right, left = np.interp(self.s, lane.s, lane.right), np.interp(self.s, lane.s, lane.left)
                mask[within & (self.d >= right) & (self.d <= left)] = True
        return mask

    @cached_property
    def elsewhere(self) -> Mask:
        """(objects,): True for moving vehicles off the lanes of the route's road, or driving across these lanes.

        Such a vehicle is on a road that joins or crosses the route's road.
        """
        speed = self.speed
        heads = np.where(speed > HEADS_MPS, np.abs(self.vd) / np.maximum(speed, HEADS_MPS), np.abs(np.sin(self.yaw)))
        vehicles = np.array([o.kind not in ON_FOOT for o in self.objects], dtype=bool)
        result: Mask = vehicles & (~self.on_lane | (heads > ACROSS_SIN)) & self.moving
        return result

    def sight_ahead_m(self, lane: Lane) -> float:
        """Return the sight distance ahead of the ego in a lane (m): the least of its entries; 0 without an entry."""
        return min((x.ahead_m for x in self.surroundings.sight if x.lane_id == lane.strip.id), default=0.0)

    def sight_behind_m(self, lane: Lane) -> float:
        """Return the sight distance behind the ego in a lane (m): the least of its entries; 0 without an entry."""
        return min((x.behind_m for x in self.surroundings.sight if x.lane_id == lane.strip.id), default=0.0)

    def free_ahead_m(self) -> float:
        """Return the gap from the front bumper to the nearest object in the route's path (m); infinite if none."""
        ahead = self.gap[self.in_corridor(self.ego.width_m / 2) & (self.s > self.ego_s)]
        return float(ahead.min()) if len(ahead) else math.inf

    def in_corridor(self, half_width_m: float, clearance_m: float = 0.2) -> Mask:
        """(objects,): True if the object reaches into a strip around the route's center.

        The half width of the strip is `half_width_m` plus `clearance_m` (m). The default clearance is ours.
        """
        result: Mask = np.abs(self.d) - self.across < half_width_m + clearance_m
        return result

    def oncoming(self, index: int) -> bool:
        """True if an object moves toward the ego, or is in a lane of oncoming traffic."""
        if self.vs[index] < -0.5:
            return True
        lane = self.lane_of[index]
        return (
            lane is not None and lane.strip.direction is LaneDirection.OPPOSITE and lane.strip.kind is LaneKind.DRIVING
        )


def _spread_m(obj: TrackedObject) -> tuple[float, float]:
    """Return the standard deviations of an object's position along and across its own axis (m)."""
    worst = obj.position_sd_m or 0.0
    return worst, worst if obj.across_sd_m is None else obj.across_sd_m
