"""A route on a map: waypoints about 1 m apart, with arc lengths and commands."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import carla
import numpy as np
from numpy.typing import NDArray

from stucksolver.scene.polyline import distances, nearest_index
from stucksolver_carla.drivers.behavior import trace_route
from stucksolver_carla.drivers.driver_interface import RoutePoint
from stucksolver_carla.stack.route_road import new_ground
from stucksolver_eval.routes.route import Position

SEARCH_BACK, SEARCH_AHEAD = 10, 60
"""Number of points before and after the last one that a projection searches first. Ours."""
LOST_M = 15.0
"""Distance from these points above which the whole route is searched (m). Ours."""

Array = NDArray[np.float64]


class RouteCommand(str, Enum):
    """The route's command at a point (the `RoadOption` of CARLA's agents)."""

    LANE_FOLLOW = "lane_follow"
    LEFT = "left"
    RIGHT = "right"
    STRAIGHT = "straight"
    CHANGE_LEFT = "change_left"
    CHANGE_RIGHT = "change_right"


@dataclass(frozen=True, eq=False)
class RouteLine:
    """A route's waypoints, with the arc length `s_m[i]` (m) and the command `commands[i]` of `waypoints[i]`."""

    waypoints: tuple[carla.Waypoint, ...]
    s_m: Array
    commands: tuple[RouteCommand, ...]

    @staticmethod
    def trace(carla_map: carla.Map, positions: Sequence[Position]) -> RouteLine:
        """Plan the shortest legal route through `positions` (CARLA's world frame). Raises `RouteError`."""
        points: list[RoutePoint] = []
        places = [carla.Location(p.x_m, p.y_m, p.z_m) for p in positions]
        for start, end in itertools.pairwise(places):
            stretch = trace_route(carla_map, start, end)
            # The end of one stretch is the start of the next.
            points.extend(stretch[1:] if points else stretch)
        return RouteLine.along(points)

    @staticmethod
    def along(points: Sequence[RoutePoint]) -> RouteLine:
        """Create a line from planned points."""
        places = [p.waypoint.transform.location for p in points]
        steps = [math.dist((a.x, a.y, a.z), (b.x, b.y, b.z)) for a, b in itertools.pairwise(places)]
        s_m = np.concatenate([[0.0], np.cumsum(steps)])
        return RouteLine(tuple(p.waypoint for p in points), s_m, tuple(RouteCommand(p.command) for p in points))

    def joined(self, index: int, other: RouteLine) -> RouteLine:
        """Return this line up to point `index`, then `other` from its nearest point, up to this line's end at most."""
        here, end = self.waypoints[index].transform.location, self.waypoints[-1].transform.location
        first = other.project(here)
        last = max(other.project(end, len(other.waypoints) - 1), first)
        return RouteLine.along(self.points[: index + 1] + other.points[first + 1 : last + 1])

    @property
    def length_m(self) -> float:
        """Length of the route (m)."""
        return float(self.s_m[-1])

    @property
    def points(self) -> tuple[RoutePoint, ...]:
        """Points of the route for a driver."""
        return tuple(RoutePoint(w, c.value) for w, c in zip(self.waypoints, self.commands, strict=True))

    @cached_property
    def xyz(self) -> Array:
        """Positions of the waypoints, shape (n, 3), in CARLA's world frame (m)."""
        places = [w.transform.location for w in self.waypoints]
        return np.array([(p.x, p.y, p.z) for p in places], dtype=np.float64)

    @cached_property
    def new_ground_m(self) -> Array:
        """Arc length at each waypoint without stretches that the route contains twice, shape (n,) (m)."""
        return new_ground(self.xyz[:, :2], self.s_m)

    @cached_property
    def forward(self) -> Array:
        """Unit vectors along the lane at the waypoints, shape (n, 3), in CARLA's world frame."""
        ahead = [w.transform.get_forward_vector() for w in self.waypoints]
        return np.array([(v.x, v.y, v.z) for v in ahead], dtype=np.float64)

    def project(self, location: carla.Location, near_index: int = 0) -> int:
        """Return the index of the waypoint nearest to a location. Searches near `near_index` first, then everywhere."""
        first = max(near_index - SEARCH_BACK, 0)
        away = distances(self.xyz[first : near_index + SEARCH_AHEAD], location.x, location.y)
        best = int(np.argmin(away))
        if away[best] < LOST_M:
            return first + best
        return nearest_index(self.xyz, location.x, location.y)

    def index_at(self, s_m: float) -> int:
        """Return the index of the waypoint nearest to an arc length (m); the first or last one beyond the ends."""
        after = int(np.clip(np.searchsorted(self.s_m, s_m), 1, len(self.s_m) - 1))
        return after if self.s_m[after] - s_m <= s_m - self.s_m[after - 1] else after - 1

    def waypoint_at(self, s_m: float) -> carla.Waypoint:
        """Return the waypoint nearest to an arc length (m); the first or last one beyond the ends."""
        return self.waypoints[self.index_at(s_m)]
