"""A running scene: the ego and the others on their road, and the report of perception about them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from lab.benchmarks.guard_oracle.bodies import Body, distance
from lab.benchmarks.guard_oracle.others import AlongLane, Other, StepsOff, Straight
from lab.benchmarks.guard_oracle.scene import Setting
from lab.benchmarks.guard_oracle.senses import in_sight, sights
from lab.benchmarks.guard_oracle.vehicle import LENGTH_M, WIDTH_M, Ego, Manner
from stucksolver.plan import Directive
from stucksolver.scene import EgoState, RoadGeometry, Surroundings, TrackedObject, TrafficControl, ZoneKind

DT = 0.05
"""Tick of the stack, and time step of the simulation (s)."""
APART_M = 0.35
"""Initial gap below which a scene is discarded (m). Ours."""
AT_REST_MPS = 0.1
"""Speed below which a vehicle counts as stopped (m/s)."""
ANSWERS_S, HARD_MPS2 = 0.5, 6.0
"""Reaction time (s) and deceleration (m/s²) of a road user that must stop."""


class World:
    """A running scene."""

    def __init__(self, setting: Setting, manner: Manner) -> None:
        self.setting = setting
        self.road = setting.road
        self.geometry: RoadGeometry = geometry_of(setting)
        x, y, heading = self.road.point_at(setting.ego_s, setting.ego_d)
        self.ego = Ego(x, y, heading + setting.ego_yaw, setting.ego_speed, manner)
        self.t = 0.0
        self.ego_stood = 30.0 if setting.ego_speed < AT_REST_MPS else 0.0
        self.others: list[Other] = setting.others
        self.begun = False
        self._s, self._d = setting.ego_s, setting.ego_d
        self.through: set[str] = set()
        """Names of road users that have driven through another actor: the others ignore each other."""
        self._corners: list[tuple[float, float]] = []
        self._locate()
        for other in self.others:
            if isinstance(other, AlongLane | Straight | StepsOff):
                other.start(self)
        rear, front, *_ = self.ego_span()
        on_rails = any(
            zone.kind is ZoneKind.LEVEL_CROSSING and zone.start_m < front and rear < zone.end_m
            for zone in self.geometry.zones
        )
        self.led_from_rails = on_rails and manner.follows and math.isfinite(self._leader()[0])
        """True if the drive starts on rails, behind a vehicle that the stack follows."""

    @property
    def ego_s(self) -> float:
        return self._s

    @property
    def ego_speed(self) -> float:
        return self.ego.speed

    def ego_body(self) -> Body:
        return self.ego.body()

    def ego_span(self) -> tuple[float, float, float, float]:
        along = [s for s, _ in self._corners]
        across = [d for _, d in self._corners]
        return min(along), max(along), min(across), max(across)

    def rear_within(self, right: float, left: float) -> float | None:
        part = clipped(clipped(self._corners, right, +1), left, -1)
        return min(s for s, _ in part) if len(part) > 2 else None

    def is_possible(self) -> bool:
        """True if no road user starts in contact, or behind the ego at an impossible speed.

        Such a road user could not have reached its position at that speed.
        """
        body = self.ego_body()
        if any(distance(body, o.body) < APART_M for o in self.others):
            return False
        pairs = [(a, b) for k, a in enumerate(self.others) for b in self.others[:k]]
        if any(distance(a.body, b.body) < 0.1 for a, b in pairs):
            return False
        return not any(isinstance(o, AlongLane) and o.was_behind and o.is_too_near(self) for o in self.others)

    def step(self, order: Directive) -> None:
        """Advance all road users by one tick."""
        room, ahead = self._leader() if self.ego.manner.follows else (math.inf, 0.0)
        self.ego.obey(order, self.t, DT, room, ahead)
        self._locate()
        for other in self.others:
            other.step(self, DT)
        self._note_who_drives_through()
        self.ego_stood = self.ego_stood + DT if abs(self.ego.speed) < AT_REST_MPS else 0.0
        self.t = round(self.t + DT, 6)

    def _note_who_drives_through(self) -> None:
        for k, item in enumerate(self.others):
            for other in self.others[:k]:
                if item.body.within(other.body, 0.0) and distance(item.body, other.body) <= 0.0:
                    self.through |= {each.name for each in (item, other) if math.hypot(each.vx, each.vy) > AT_REST_MPS}

    def sees(self, other: Other) -> bool:
        """True if a road user is in sight of the ego."""
        reach = max(self.setting.ahead_m, 60.0) if self.setting.reach_m is None else self.setting.reach_m
        return in_sight((self.ego.x, self.ego.y), other, self._hiding(), reach)

    def _hiding(self) -> list[tuple[Body, float]]:
        """Return bodies that may hide others, and their heights (m)."""
        return [(o.body, o.height) for o in self.others] + self.setting.walls

    def surroundings(self) -> Surroundings:
        """Return the present report of perception."""
        setting, ego = self.setting, self.ego
        eye, visible = (ego.x, ego.y), []
        for other in self.others:
            if self.sees(other):
                if other.seen_at is None:
                    other.seen_at = self.t
                visible.append(tracked(other, self.t))
        front = self.ego_span()[1]
        return Surroundings.model_construct(
            frame=round(self.t / DT),
            time_s=100.0 + self.t,
            age_s=0.0,
            ego=EgoState.model_construct(
                x_m=ego.x,
                y_m=ego.y,
                yaw_rad=math.remainder(ego.yaw, math.tau),
                speed_mps=ego.speed,
                length_m=LENGTH_M,
                width_m=WIDTH_M,
                limits=LIMITS,
            ),
            objects=tuple(visible),
            controls=tuple(
                TrafficControl(kind=c.kind, distance_m=c.line - front, applies=True, state=c.state(self.t))
                for c in setting.controls
                if c.line - front < c.seen_from
            ),
            sight=sights(self.road, eye, self._s, self._hiding(), setting.ahead_m, setting.behind_m),
            road=self.geometry,
        )

    def touched(self) -> Other | None:
        """Return the first of the others that the ego touches."""
        return next(iter(self.all_touched()), None)

    def all_touched(self) -> Iterator[Other]:
        """Yield all others that the ego touches."""
        body = self.ego_body()
        near = (o for o in self.others if body.within(o.body, 0.0))
        return (o for o in near if body.polygon().intersects(o.body.polygon()))

    def nearest(self) -> float:
        body = self.ego_body()
        return min((distance(body, o.body, 1.0) for o in self.others), default=1.0)

    def _locate(self) -> None:
        ego = self.ego
        self._s, self._d = self.road.find(ego.x, ego.y, self._s)
        _, _, heading = self.road.point_at(self._s)
        c, n = math.cos(ego.yaw - heading), math.sin(ego.yaw - heading)
        a, b = LENGTH_M / 2, WIDTH_M / 2
        self._corners = [
            (self._s + i * a * c - j * b * n, self._d + i * a * n + j * b * c)
            for i, j in ((1, 1), (1, -1), (-1, -1), (-1, 1))
        ]

    def _leader(self) -> tuple[float, float]:
        """Return the gap to the next vehicle ahead that moves, or moved, in the ego's direction (m), and its speed."""
        front = self.ego_span()[1]
        right, left = sorted(d for _, d in self._corners[:2])
        found = (math.inf, 0.0)
        for o in self.others:
            if not isinstance(o, AlongLane) or o.way < 0 or (o.v < 0.3 and o.role == "queues"):
                continue
            gap = o.s - o.body.length / 2 - front
            half = o.body.width / 2 + 0.2
            if -1.0 < gap < found[0] and o.d - half < left and o.d + half > right:
                found = (gap, o.v)
        return found


LIMITS = EgoState.model_fields["limits"].get_default()


def geometry_of(setting: Setting) -> RoadGeometry:
    """Return the description of a scene's road, created once."""
    known: Any = getattr(setting.road, "_told", None)
    if known is None:
        known = setting.road.geometry()
        setting.road._told = known  # type: ignore[attr-defined]
    geometry: RoadGeometry = known
    return geometry


def tracked(other: Other, t: float) -> TrackedObject:
    """Return one of the others in the report of a perfect tracker."""
    visible_s = t - (other.seen_at or 0.0)
    return TrackedObject.model_construct(
        id=other.name,
        kind=other.kind,
        x_m=other.body.x,
        y_m=other.body.y,
        yaw_rad=math.remainder(other.body.yaw, math.tau),
        vx_mps=other.vx,
        vy_mps=other.vy,
        length_m=other.body.length,
        width_m=other.body.width,
        height_m=other.height,
        stationary_s=other.stood,
        moved_s_ago=other.moved_ago,
        pushed=False,
        seen_for_s=10.0 + visible_s,
        kind_confidence=0.95,
        hazard_lights=other.hazard,
        emergency_lights=None,
        brake_lights=None,
    )


def clipped(points: list[tuple[float, float]], border: float, keeps: int) -> list[tuple[float, float]]:
    """Return a polygon in (s, d), cut at an offset: +1 leaves the part to its left, -1 the part to its right."""
    found = []
    for k, here in enumerate(points):
        before = points[k - 1]
        a, b = (before[1] - border) * keeps, (here[1] - border) * keeps
        if (a > 0) != (b > 0):
            part = a / (a - b)
            found.append((before[0] + part * (here[0] - before[0]), border))
        if b > 0:
            found.append(here)
    return found
