"""The oracle's own roads: a line of given curvature with lanes, and its description for the guard."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from stucksolver.scene import (
    LaneDirection,
    LaneKind,
    LaneStrip,
    LineKind,
    RoadGeometry,
    Zone,
    ZoneKind,
)

FINE_M = 0.5
"""Distance between points of the line (m)."""
SPACING_M = 2.0
"""Distance between points of the description for the guard (m)."""
SAME, OPPOSITE = LaneDirection.SAME, LaneDirection.OPPOSITE


@dataclass(frozen=True)
class OwnLane:
    """A lane of the oracle: offset of its center to the left of the line, and its width (m)."""

    name: str
    offset: float
    width: float
    direction: LaneDirection = SAME
    kind: LaneKind = LaneKind.DRIVING
    line: LineKind = LineKind.BROKEN

    @property
    def right_m(self) -> float:
        return self.offset - self.width / 2

    @property
    def left_m(self) -> float:
        return self.offset + self.width / 2


@dataclass
class Road:
    """A chain of segments (length m, curvature 1/m) that starts at the origin along x, with lanes and zones."""

    key: str
    pieces: list[tuple[float, float]]
    lanes: list[OwnLane]
    zones: list[tuple[ZoneKind, float, float]] = field(default_factory=list)
    limit: float = 13.9
    """Speed limit of all lanes (m/s)."""

    def __post_init__(self) -> None:
        bends = np.concatenate([np.full(round(length / FINE_M), bend) for length, bend in self.pieces])
        turned = np.concatenate([[0.0], np.cumsum(bends * FINE_M)])
        middle = (turned[:-1] + turned[1:]) / 2
        self._s = FINE_M * np.arange(len(turned))
        self._x = np.concatenate([[0.0], np.cumsum(FINE_M * np.cos(middle))])
        self._y = np.concatenate([[0.0], np.cumsum(FINE_M * np.sin(middle))])
        self._turned = turned
        self.end = float(self._s[-1])
        # Lists are far quicker than arrays here: single points are requested a hundred thousand times.
        self._line = self._x.tolist(), self._y.tolist(), turned.tolist()

    def point_at(self, s: float, d: float = 0.0) -> tuple[float, float, float]:
        """Return (x, y, heading) of the point `s` meters along and `d` to the left; straight beyond the ends."""
        inside = min(max(s, 0.0), self.end)
        xs, ys, turned = self._line
        k = min(int(inside / FINE_M), len(xs) - 2)
        part = inside / FINE_M - k
        heading = turned[k] + part * (turned[k + 1] - turned[k])
        x = xs[k] + part * (xs[k + 1] - xs[k])
        y = ys[k] + part * (ys[k + 1] - ys[k])
        c, n, beyond = math.cos(heading), math.sin(heading), s - inside
        return float(x + beyond * c - d * n), float(y + beyond * n + d * c), float(heading)

    def find(self, x: float, y: float, near: float) -> tuple[float, float]:
        """Return (s, d) of a point close to arc length `near`."""
        s = near
        for _ in range(6):
            px, py, heading = self.point_at(s)
            step = (x - px) * math.cos(heading) + (y - py) * math.sin(heading)
            s += step
            if abs(step) < 1e-3:
                break
        px, py, heading = self.point_at(s)
        return s, (y - py) * math.cos(heading) - (x - px) * math.sin(heading)

    def points_at(self, s: np.ndarray, d: float) -> tuple[np.ndarray, np.ndarray]:
        """Return (x, y) of many points within the length of the line."""
        heading = np.interp(s, self._s, self._turned)
        x, y = np.interp(s, self._s, self._x), np.interp(s, self._s, self._y)
        return x - d * np.sin(heading), y + d * np.cos(heading)

    def lane(self, name: str) -> OwnLane:
        """Return the lane with this name."""
        return next(lane for lane in self.lanes if lane.name == name)

    def geometry(self) -> RoadGeometry:
        """Return the road as the stack would report it."""
        count = int(self.end / SPACING_M) + 1
        points = tuple(self.point_at(SPACING_M * k)[:2] for k in range(count))
        strips = tuple(
            LaneStrip(
                id=lane.name,
                kind=lane.kind,
                direction=lane.direction,
                start=0,
                offset_m=(lane.offset,) * count,
                width_m=(lane.width,) * count,
                line=(LineKind.NONE if abs(lane.offset) < 0.1 else lane.line,) * count,
                speed_limit_mps=self.limit,
            )
            for lane in self.lanes
        )
        zones = tuple(Zone(kind=kind, start_m=start, end_m=end) for kind, start, end in self.zones)
        return RoadGeometry(key=self.key, spacing_m=SPACING_M, reference=points, lanes=strips, zones=zones)


def lanes_of(layout: str, width: float = 3.5) -> list[OwnLane]:
    """Return the lanes of a layout: "two_way", "multi" (a lane of the ego's direction on the left), "right", "both".

    The suffix "_shoulder" or "_parking" adds a strip of that kind on the right.
    """
    base, _, strip = layout.partition("_")
    if base == "two":
        base, _, strip = "two_way", "", strip.removeprefix("way").removeprefix("_")
    found = [OwnLane("own", 0.0, width)]
    left = width
    if base in ("multi", "both"):
        found.append(OwnLane("left", left, width))
        left += width
    if base in ("two_way", "both"):
        found.append(OwnLane("oncoming", left, width, OPPOSITE))
    if base == "right":
        found.append(OwnLane("right", -width, width))
    if strip:
        kind = LaneKind.PARKING if strip == "parking" else LaneKind.SHOULDER
        found.append(OwnLane("roadside", -width / 2 - 1.15, 2.3, kind=kind))
    return found
