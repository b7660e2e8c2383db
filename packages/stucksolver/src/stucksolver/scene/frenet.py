"""Road coordinates: arc length `s` along the route and lateral offset `d` from it, left positive, in meters."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stucksolver.scene.road import LaneKind, LaneStrip, LineKind, RoadGeometry

Array = NDArray[Any]
Mask = NDArray[np.bool_]
"""True or False for each station, object or time."""


def wrap_angle(angle: Array) -> Array:
    """Wrap angles to [-pi, pi) (rad)."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


@dataclass(frozen=True)
class Lane:
    """Lane strip as arrays over its stretch of the reference line.

    Attributes:
        strip: Lane as described by the stack.
        start_m: Arc length of the first station (m).
        end_m: Arc length of the last station (m).
        s: (stations,): arc lengths (m).
        center: (stations,): lateral offsets of the center (m, left positive).
        left: (stations,): lateral offsets of the left border (m).
        right: (stations,): lateral offsets of the right border (m).
    """

    strip: LaneStrip
    start_m: float
    end_m: float
    s: Array
    center: Array
    left: Array
    right: Array

    def covers(self, start_m: float, end_m: float) -> bool:
        """True if the lane covers the route from arc length `start_m` to `end_m` (m)."""
        return self.start_m <= start_m and end_m <= self.end_m

    def at(self, s: float) -> tuple[float, float, float]:
        """Return the offsets of (right border, center, left border) at arc length `s` (m), constant beyond the ends."""
        last = len(self.s) - 1
        i = min(max((s - self.start_m) / self.spacing, 0.0), float(last))
        k = min(int(i), max(last - 1, 0))
        j, f = min(k + 1, last), i - k
        right, center, left = (float(a[k] * (1 - f) + a[j] * f) for a in (self.right, self.center, self.left))
        return right, center, left

    @cached_property
    def spacing(self) -> float:
        """Distance between stations (m)."""
        return float(self.s[1] - self.s[0]) if len(self.s) > 1 else 1.0

    def lines(self, start_m: float, end_m: float) -> frozenset[LineKind]:
        """Return the kinds of line between this lane and its neighbor toward the route, on a stretch (m)."""
        first = int(np.searchsorted(self.s, start_m - self.spacing))
        last = int(np.searchsorted(self.s, end_m + self.spacing, side="right"))
        return frozenset(self.strip.line[first:last])


class RoadFrame:
    """Converts between the local frame and road coordinates, and finds lanes by arc length."""

    def __init__(self, road: RoadGeometry) -> None:
        self.road = road
        self.points: Array = np.asarray(road.reference, dtype=float)
        steps = np.diff(self.points, axis=0)
        lengths = np.maximum(np.hypot(steps[:, 0], steps[:, 1]), 1e-9)
        self.s: Array = road.route_start_m + np.concatenate([[0.0], np.cumsum(lengths)])
        self.directions: Array = steps / lengths[:, None]
        self.end_m = float(self.s[-1])
        headings = np.unwrap(np.arctan2(self.directions[:, 1], self.directions[:, 0]))
        at_joints = (headings[:-1] + headings[1:]) / 2
        self.headings: Array = np.concatenate([headings[:1], at_joints, headings[-1:]])
        self.lanes: tuple[Lane, ...] = tuple(self._lane(strip) for strip in road.lanes)

    def _lane(self, strip: LaneStrip) -> Lane:
        count = min(len(strip.offset_m), len(self.s) - strip.start)
        s = self.s[strip.start : strip.start + count]
        center = np.asarray(strip.offset_m[:count])
        half = np.asarray(strip.width_m[:count]) / 2
        return Lane(strip, float(s[0]), float(s[-1]), s, center, center + half, center - half)

    def to_road(self, xy: Array) -> tuple[Array, Array, Array]:
        """Convert local points (n, 2) (m) to s (m), d (m) and road heading (rad), each (n,).

        The reference line is extended straight beyond its ends.
        """
        xy = np.atleast_2d(xy)
        dx, dy = xy[:, :1] - self.points[:, 0], xy[:, 1:] - self.points[:, 1]
        nearest = (dx * dx + dy * dy).argmin(axis=1)
        best: tuple[Array, Array, Array] | None = None
        for segment in (np.maximum(nearest - 1, 0), np.minimum(nearest, len(self.directions) - 1)):
            candidate = self._project(xy, segment)
            if best is None:
                best = candidate
            else:
                better = candidate[2] < best[2] - 1e-12
                best = tuple(np.where(better, c, b) for c, b in zip(candidate, best, strict=True))  # type: ignore[assignment]
        assert best is not None
        return best[0], best[1], np.interp(best[0], self.s, self.headings)

    def _project(self, xy: Array, segment: NDArray[np.intp]) -> tuple[Array, Array, Array]:
        """Return (s, d, distance), each (n,) (m), of each point to its segment. Only the end segments are extended."""
        direction = self.directions[segment]
        relative = xy - self.points[segment]
        along = (relative * direction).sum(axis=1)
        lateral = direction[:, 0] * relative[:, 1] - direction[:, 1] * relative[:, 0]
        low = np.where(segment == 0, -np.inf, 0.0)
        high = np.where(segment == len(self.directions) - 1, np.inf, self.s[segment + 1] - self.s[segment])
        clipped = np.minimum(np.maximum(along, low), high)
        return self.s[segment] + clipped, lateral, np.hypot(lateral, along - clipped)

    def to_local(self, s: Array, d: Array) -> tuple[Array, Array, Array]:
        """Convert road coordinates (n,) (m) to (x, y, road heading) in the local frame, each (n,) (m, m, rad)."""
        index = np.clip(np.searchsorted(self.s, s, side="right") - 1, 0, len(self.directions) - 1)
        along = (s - self.s[index])[:, None] * self.directions[index]
        heading = np.interp(s, self.s, self.headings)
        base = self.points[index] + along
        return base[:, 0] - np.sin(heading) * d, base[:, 1] + np.cos(heading) * d, heading

    def same_lane(self, lane: Lane) -> Lane:
        """Return the lane with the same id in this stretch of road, or the given lane if there is none."""
        return next((item for item in self.lanes if item.strip.id == lane.strip.id), lane)

    def lane_at(self, s: float, d: float) -> Lane | None:
        """Return the lane that contains a point (m), with overlapping lanes the one with the nearest center.

        None off the lanes.
        """
        best: Lane | None = None
        nearest = np.inf
        for lane in self.lanes:
            if not lane.start_m - 1.0 <= s <= lane.end_m + 1.0:
                continue
            right, center, left = lane.at(s)
            if right - 1e-6 <= d <= left + 1e-6 and abs(d - center) < nearest:
                best, nearest = lane, abs(d - center)
        return best

    @cached_property
    def drivable(self) -> tuple[Array, Array]:
        """Right and left border of the connected driving lanes around the route, each (stations,) (m)."""
        return self._borders(frozenset({LaneKind.DRIVING}))

    @cached_property
    def roadside(self) -> tuple[Array, Array]:
        """The same borders including parking lanes and shoulders, where a vehicle may stop."""
        return self._borders(frozenset({LaneKind.DRIVING, LaneKind.PARKING, LaneKind.SHOULDER}))

    def _borders(self, kinds: frozenset[LaneKind]) -> tuple[Array, Array]:
        low, high = np.zeros(len(self.s)), np.zeros(len(self.s))
        spans: list[list[tuple[float, float]]] = [[] for _ in self.s]
        for lane in self.lanes:
            if lane.strip.kind in kinds:
                for k, (right, left) in enumerate(zip(lane.right, lane.left, strict=True)):
                    spans[lane.strip.start + k].append((float(right), float(left)))
        for k, here in enumerate(spans):
            low[k], high[k] = _connected(here)
        return low, high

    def beside(self, s: float, d: float, side: int) -> Lane | None:
        """Return the adjacent lane of any kind on a side (+1 left, -1 right) of the lane that contains (s, d) (m)."""
        here = self.lane_at(s, d)
        origin = here.at(s)[1] if here is not None else d
        candidates = [
            ((lane.at(s)[1] - origin) * side, lane)
            for lane in self.lanes
            if lane is not here and lane.start_m - 1.0 <= s <= lane.end_m + 1.0
        ]
        nearest = min((pair for pair in candidates if pair[0] > 0.5), key=lambda pair: pair[0], default=None)
        return nearest[1] if nearest else None


JOINT_M = 0.3
"""Largest distance at which two lanes count as touching (m). Ours."""


def _connected(spans: list[tuple[float, float]]) -> tuple[float, float]:
    """Return the connected union of spans around zero; (0, 0) if no span contains zero."""
    own = next((span for span in spans if span[0] <= 0.0 <= span[1]), None)
    if own is None:
        return 0.0, 0.0
    low, high = own
    for right, left in sorted(spans):
        if right <= high + JOINT_M:
            high = max(high, left)
    for right, left in sorted(spans, key=lambda span: -span[1]):
        if left >= low - JOINT_M:
            low = min(low, right)
    return low, high


@lru_cache(maxsize=8)
def _frame_of(key: str, road: RoadGeometryByKey) -> RoadFrame:
    return RoadFrame(road.road)


@dataclass(frozen=True, eq=False)
class RoadGeometryByKey:
    """Geometry that is hashed by its key, so that the cache does not hash thousands of numbers."""

    road: RoadGeometry

    def __hash__(self) -> int:
        return hash(self.road.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, RoadGeometryByKey) and (
            self.road is other.road or (self.road.key == other.road.key and self.road == other.road)
        )


def road_frame(road: RoadGeometry) -> RoadFrame:
    """Return the frame of a road geometry. It is cached from tick to tick."""
    return _frame_of(road.key, RoadGeometryByKey(road))
