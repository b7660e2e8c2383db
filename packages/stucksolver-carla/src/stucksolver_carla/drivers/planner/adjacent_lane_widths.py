"""Measures the widths of the lanes next to the route's lane, in both directions, once per route."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stucksolver.scene.polyline import arc_lengths
from stucksolver_bridge.traffic_side import drives_on_left
from stucksolver_carla.drivers.behavior.path import Array, Path
from stucksolver_carla.drivers.driver_interface import RoutePoint

if TYPE_CHECKING:
    import carla

_ON_LINE_M = 0.5
"""Maximum distance between a route point and the line for known widths (m); it is larger in lane changes. Ours."""


class LaneWidths(NamedTuple):
    """Minimum widths of the lanes along a stretch (m); 0 without a lane."""

    half: float
    """Half the width of the ego's lane."""
    left_same: float
    """Width of the left lane of the same direction."""
    left_oncoming: float
    """Width of the left lane of the opposite direction."""
    right_same: float
    """Width of the right lane of the same direction."""
    right_oncoming: float = 0.0
    """Width of the right lane of the opposite direction, in left-hand traffic."""


CLOSED = LaneWidths(0.0, 0.0, 0.0, 0.0)
"""The widths of a stretch without known lanes."""


@dataclass(frozen=True, eq=False)
class AdjacentLaneWidths:
    """Widths at each point of the route. Adjacent lanes have width 0 in junctions and in lane changes."""

    s: Array
    widths: Array
    """(n, 5), in the order of `LaneWidths`."""
    edge_side: float = 1.0
    """Side of the road's edge: 1 for the right in right-hand traffic, -1 for the left in left-hand traffic."""

    def narrowest(self, start_m: float, end_m: float) -> LaneWidths:
        """Return the minimum widths along the route from `start_m` to `end_m`."""
        low, high = np.searchsorted(self.s, (start_m, end_m))
        if high >= len(self.s):
            return CLOSED
        return LaneWidths(*(float(item) for item in self.widths[low : high + 1].min(axis=0)))

    def junction_after(self, s_m: float) -> float:
        """Return the start of the next stretch without known adjacent lanes (m); infinity without one."""
        closed = np.flatnonzero((self.s > s_m) & (self.widths[:, 1:].max(axis=1) <= 0.0))
        return float(self.s[closed[0]]) if len(closed) else np.inf


def lane_widths_along(route: Sequence[RoutePoint], line: Path) -> AdjacentLaneWidths:
    """Return the lane widths at each point of a route."""
    locations = [point.waypoint.transform.location for point in route]
    xy = np.array([(location.x, location.y) for location in locations])
    arc = arc_lengths(xy)
    s = arc * (line.length / max(float(arc[-1]), 1e-6))
    x, y, _ = line.at(s)
    on_line = np.hypot(xy[:, 0] - x, xy[:, 1] - y) < _ON_LINE_M
    widths = [
        _lane_widths(point.waypoint) if is_on_line else CLOSED
        for point, is_on_line in zip(route, on_line.tolist(), strict=True)
    ]
    edge_side = -1.0 if any(drives_on_left(point.waypoint) for point in route[:1]) else 1.0
    return AdjacentLaneWidths(s, np.array(widths, dtype=np.float64).reshape(len(route), 5), edge_side)


def _lane_widths(waypoint: carla.Waypoint) -> LaneWidths:
    half = float(waypoint.lane_width) / 2.0
    if waypoint.is_junction:
        return LaneWidths(half, 0.0, 0.0, 0.0)
    left, right = _widths_of(waypoint.get_left_lane(), waypoint), _widths_of(waypoint.get_right_lane(), waypoint)
    return LaneWidths(half, *left, *right)


def _widths_of(lane: carla.Waypoint | None, own: carla.Waypoint) -> tuple[float, float]:
    """Return the width of an adjacent driving lane, as (same direction, opposite direction); the other one is 0."""
    if lane is None or not str(lane.lane_type).endswith("Driving"):
        return 0.0, 0.0
    width = float(lane.lane_width)
    return (width, 0.0) if lane.lane_id * own.lane_id > 0 else (0.0, width)
