"""The lanes beside the route's lane, in its direction and in the other, measured once per route."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stucksolver.scene.polyline import arc_lengths
from stucksolver_carla.drivers.behavior.path import Array, Path
from stucksolver_carla.drivers.driver_interface import RoutePoint

if TYPE_CHECKING:
    import carla

_BESIDE_THE_LINE_M = 0.5


class LaneWidths(NamedTuple):
    """Widths of the lanes along a stretch, each at its narrowest (m); 0 where there is none."""

    half: float
    """Half the width of the ego's lane."""
    left_same: float
    """Lane on the left of the same direction."""
    left_oncoming: float
    right_same: float


CLOSED = LaneWidths(0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class AdjacentLaneWidths:
    """Widths at each point of the route; zero beside it in a junction and during lane changes."""

    s: Array
    widths: Array
    """(n, 4), in the order of `LaneWidths`."""

    def room(self, start_m: float, end_m: float) -> LaneWidths:
        """Along the route from `start_m` to `end_m`."""
        low, high = np.searchsorted(self.s, (start_m, end_m))
        if high >= len(self.s):
            return CLOSED
        return LaneWidths(*(float(item) for item in self.widths[low : high + 1].min(axis=0)))

    def junction_after(self, s_m: float) -> float:
        """Return the start of the next stretch beside which nothing is known (m); infinite if there is none."""
        closed = np.flatnonzero((self.s > s_m) & (self.widths[:, 1:].max(axis=1) <= 0.0))
        return float(self.s[closed[0]]) if len(closed) else np.inf


def sides_of(route: Sequence[RoutePoint], line: Path) -> AdjacentLaneWidths:
    """Return the lanes beside each point of a route."""
    places = [point.waypoint.transform.location for point in route]
    xy = np.array([(place.x, place.y) for place in places])
    arc = arc_lengths(xy)
    s = arc * (line.length / max(float(arc[-1]), 1e-6))
    x, y, _ = line.at(s)
    on_line = np.hypot(xy[:, 0] - x, xy[:, 1] - y) < _BESIDE_THE_LINE_M
    widths = [_room(point.waypoint) if known else CLOSED for point, known in zip(route, on_line.tolist(), strict=True)]
    return AdjacentLaneWidths(s, np.array(widths, dtype=np.float64).reshape(len(route), 4))


def _room(waypoint: carla.Waypoint) -> LaneWidths:
    half = float(waypoint.lane_width) / 2.0
    if waypoint.is_junction:
        return LaneWidths(half, 0.0, 0.0, 0.0)
    left, right = _driving(waypoint.get_left_lane()), _driving(waypoint.get_right_lane())
    same = left is not None and left.lane_id * waypoint.lane_id > 0
    width = 0.0 if left is None else float(left.lane_width)
    beside = right is not None and right.lane_id * waypoint.lane_id > 0
    return LaneWidths(
        half,
        width if same else 0.0,
        0.0 if same else width,
        float(right.lane_width) if right is not None and beside else 0.0,
    )


def _driving(waypoint: carla.Waypoint | None) -> carla.Waypoint | None:
    return waypoint if waypoint is not None and str(waypoint.lane_type).endswith("Driving") else None
