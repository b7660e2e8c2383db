"""One tick's surroundings in road coordinates: what behaviours and the guard compute with."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from stucksolver.scene.frenet import Array, Lane, Mask, RoadFrame, road_frame, wrap_angle
from stucksolver.scene.mirror import backwards
from stucksolver.scene.objects import ON_FOOT, STATIC_KINDS, TWO_WHEELED, VULNERABLE, TrackedObject
from stucksolver.scene.road import LaneDirection, LaneKind, Zone, ZoneKind
from stucksolver.scene.surroundings import Surroundings

ACROSS_SIN = math.sin(math.radians(20.0))
HEADS_MPS = 1.0
"""Above this speed the way that something goes tells more than the way that it points."""
MOVING_MPS = 0.1
"""Above this speed an object counts as moving."""
SURE_SDS = 2.0
"""Boxes are taken to be larger on every side by so many standard deviations of their places: 95 % of a normal error."""


class FrenetScene:
    """Arrays over the objects (index as in `objects`) and the ego, in road coordinates: all of shape (objects,).

    `s`, `d`: box centres; `yaw`: heading relative to the road; `vs`, `vd`: velocity along and across;
    `half_length`, `half_width`: of the boxes, grown by what perception is not sure of; `along`, `across`: half extents
    of these boxes seen along the road.
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
        s, d, heading = self.frame.to_road(everyone[:, :2])
        yaw = wrap_angle(everyone[:, 2] - heading)
        self.ego_s, self.ego_d, self.ego_yaw = float(s[0]), float(d[0]), float(yaw[0])
        self.s, self.d, self.yaw = s[1:], d[1:], yaw[1:]
        cos, sin = np.cos(heading[1:]), np.sin(heading[1:])
        vx, vy = everyone[1:, 3], everyone[1:, 4]
        self.vs, self.vd = vx * cos + vy * sin, vy * cos - vx * sin
        grown = SURE_SDS * np.array([o.position_sd_m or 0.0 for o in surroundings.objects])
        self.half_length, self.half_width = everyone[1:, 5] / 2 + grown, everyone[1:, 6] / 2 + grown
        c, n = np.abs(np.cos(self.yaw)), np.abs(np.sin(self.yaw))
        self.along: Array = self.half_length * c + self.half_width * n
        self.across: Array = self.half_length * n + self.half_width * c

    @cached_property
    def backwards(self) -> FrenetScene:
        """The same tick as one sees it who backs up along the route: forward is behind, left is right."""
        return FrenetScene(backwards(self.surroundings))

    @cached_property
    def on_foot(self) -> Mask:
        """(objects,): may they step into the road?"""
        return np.array([o.kind in ON_FOOT for o in self.objects], dtype=bool)

    @cached_property
    def vulnerable(self) -> Mask:
        """(objects,): are they vulnerable road users?"""
        return np.array([o.kind in VULNERABLE for o in self.objects], dtype=bool)

    @cached_property
    def two_wheeled(self) -> Mask:
        """(objects,): are they on two wheels?"""
        return np.array([o.kind in TWO_WHEELED for o in self.objects], dtype=bool)

    @cached_property
    def moving(self) -> Mask:
        """(objects,): do they move?"""
        still = np.array([o.kind in STATIC_KINDS for o in self.objects], dtype=bool)
        result: Mask = (np.hypot(self.vs, self.vd) > MOVING_MPS) & ~still
        return result

    def index_of(self, object_id: str) -> int | None:
        """Where an object stands in the arrays, None if it is not seen now."""
        return next((i for i, o in enumerate(self.objects) if o.id == object_id), None)

    def zone_at(self, s: float, *kinds: ZoneKind) -> Zone | None:
        """The zone that the ego's body would touch with its centre at `s`; of the given kinds, if any are given."""
        half = self.ego.length_m / 2
        for zone in self.surroundings.road.zones:
            if zone.start_m < s + half and s - half < zone.end_m and (not kinds or zone.kind in kinds):
                return zone
        return None

    @property
    def ego_front_s(self) -> float:
        """The vehicle's front bumper along the route (m)."""
        return self.ego_s + self.ego.length_m / 2

    @cached_property
    def gap(self) -> Array:
        """From the ego's front bumper to each object's near side along the road; negative beside or behind."""
        return self.s - self.along - self.ego_front_s

    @cached_property
    def ego_lane(self) -> Lane | None:
        """The lane in which the vehicle's centre is, if it is in one."""
        return self.frame.lane_at(self.ego_s, self.ego_d)

    @cached_property
    def lane_of(self) -> tuple[Lane | None, ...]:
        """The lane that holds each object's centre."""
        return tuple(self.frame.lane_at(float(s), float(d)) for s, d in zip(self.s, self.d, strict=True))

    @cached_property
    def on_lane(self) -> Mask:
        """(objects,): have they their centre on a lane of the route's road?"""
        found = np.zeros(len(self.objects), dtype=bool)
        for lane in self.frame.lanes:
            # Before and beyond what is known of the road, its lanes are taken to go on.
            start = -np.inf if lane.start_m <= self.frame.s[0] else lane.start_m
            end = np.inf if lane.end_m >= self.frame.end_m else lane.end_m
            beside = (self.s >= start) & (self.s <= end)
            if beside.any():
                right, left = np.interp(self.s, lane.s, lane.right), np.interp(self.s, lane.s, lane.left)
                found[beside & (self.d >= right) & (self.d <= left)] = True
        return found

    @cached_property
    def elsewhere(self) -> Mask:
        """(objects,): are they vehicles under way on no lane of the route's road, or across them?

        Such are on roads that join or cross it.
        """
        speed = np.hypot(self.vs, self.vd)
        heads = np.where(speed > HEADS_MPS, np.abs(self.vd) / np.maximum(speed, HEADS_MPS), np.abs(np.sin(self.yaw)))
        vehicles = np.array([o.kind not in ON_FOOT for o in self.objects], dtype=bool)
        result: Mask = vehicles & (~self.on_lane | (heads > ACROSS_SIN)) & self.moving
        return result

    def sight_ahead_m(self, lane: Lane) -> float:
        """How far a lane is seen ahead of the ego; 0 where the surroundings do not say."""
        return next((x.ahead_m for x in self.surroundings.sight if x.lane_id == lane.strip.id), 0.0)

    def sight_behind_m(self, lane: Lane) -> float:
        """How far a lane is seen behind the ego; 0 where the surroundings do not say."""
        return next((x.behind_m for x in self.surroundings.sight if x.lane_id == lane.strip.id), 0.0)

    def free_ahead_m(self) -> float:
        """From the front bumper to the nearest thing in the ego's way along the route; infinite where there is none."""
        ahead = self.gap[self.in_corridor(self.ego.width_m / 2) & (self.s > self.ego_s)]
        return float(ahead.min()) if len(ahead) else math.inf

    def in_corridor(self, half_width_m: float, clearance_m: float = 0.2) -> Mask:
        """(objects,): do they reach into a strip of that half width around the route's centre line?"""
        result: Mask = np.abs(self.d) - self.across < half_width_m + clearance_m
        return result

    def oncoming(self, index: int) -> bool:
        """Does an object come towards us, or stand in a lane whose traffic does?"""
        if self.vs[index] < -0.5:
            return True
        lane = self.lane_of[index]
        return (
            lane is not None and lane.strip.direction is LaneDirection.OPPOSITE and lane.strip.kind is LaneKind.DRIVING
        )
