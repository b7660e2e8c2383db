"""Where the ways of others meet the route at junctions: computed once per route, from the lane graph.

CARLA's world frame, meters, radians.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stucksolver.scene.polyline import arc_lengths, nearest_index
from stucksolver_carla.drivers.behavior.lane_graph import LaneGraph, LaneKey, lane_key
from stucksolver_carla.drivers.behavior.path import Array, Path
from stucksolver_carla.drivers.behavior.routing import TURN_THRESHOLD_RAD
from stucksolver_carla.drivers.driver_interface import RoutePoint

if TYPE_CHECKING:
    import carla

MEETS_M = 2.2
"""Closer center lines cannot be driven at once: two cars' half widths and a hand's breadth."""
UPSTREAM_M = 90.0
DOWNSTREAM_M = 40.0
FASTEST_LATERAL_MPS2 = 6.0
"""Vehicles that would need more sideways acceleration than this do not take a bend."""
_BEND_OVER = 4
_BEYOND_M = 8.0
_OPPOSED_COS = math.cos(math.radians(150.0))
_CLEARLY_RAD = 0.05
_FROM_THE_RIGHT_RAD = math.radians(30.0)


@dataclass(frozen=True, eq=False)
class ConflictPath:
    """A way through a junction that crosses or joins the route; samples about a meter apart, upstream first."""

    x: Array
    y: Array
    yaw: Array
    s: Array
    """Arc length along it (m)."""
    inside_s: float
    """Where it enters the junction."""
    meets_s: float
    """Where it meets the route."""
    parts_s: float
    """Where it has left the route again; the end of the junction if it joins."""
    route_meets_s: float
    route_parts_s: float
    """The same places along the route's line."""
    straight: bool
    bend_mps: float
    """The highest speed through its bend (m/s)."""
    joins: bool
    """True if it continues along the route instead of crossing it."""
    approach: LaneKey
    """The lane that leads to the junction."""
    goes_first: bool
    """True if it has the right of way over the route, lights aside."""
    lights: tuple[carla.TrafficLight, ...]
    """The `carla.TrafficLight`s that govern it."""


@dataclass(frozen=True, eq=False)
class JunctionConflicts:
    """One junction of the route: where to wait before it (arc length, m), and the ways met there."""

    wait_s: float
    ways: tuple[ConflictPath, ...]

    @property
    def first_s(self) -> float:
        """Where the route meets the first of them (m)."""
        return min(way.route_meets_s for way in self.ways)

    @property
    def last_s(self) -> float:
        """Where it has left the last of them (m)."""
        return max(way.route_parts_s for way in self.ways)


def meetings(
    route: Sequence[RoutePoint],
    line: Path,
    graph: LaneGraph,
    lights: Sequence[carla.TrafficLight],
    stops_s: Sequence[float],
    upstream_m: float = UPSTREAM_M,
) -> list[JunctionConflicts]:
    """Return the junctions of a route at which others may come.

    Of two ways the turning one gives way, left turns to all. If both turn alike, the one that bends more gives way
    where they join, and the one that has the other on its right where they cross. After a stop sign all others go
    first.

    Args:
        route: The route.
        line: The route's path.
        graph: The lane graph.
        lights: The map's `carla.TrafficLight`s.
        stops_s: Places of the route's stop signs on the line (m).
        upstream_m: How far up the roads the others begin (m).
    """
    governing: dict[tuple[int, int], list[Any]] = {}
    for light in lights:
        for waypoint in light.get_stop_waypoints():
            governing.setdefault((waypoint.road_id, waypoint.lane_id), []).append(light)
    found = []
    for first, last in _junction_stretches(route):
        here = _Junction(route, line, graph, governing, first, last, upstream_m)
        stop_sign = any(-15.0 < here.enter_s - s < 15.0 for s in stops_s)
        ways = tuple(way for way in here.ways(stop_sign))
        if ways:
            found.append(JunctionConflicts(here.enter_s, ways))
    return found


class _Junction:
    """One stretch of the route through a junction, and the other ways through that junction."""

    def __init__(
        self,
        route: Sequence[RoutePoint],
        line: Path,
        graph: LaneGraph,
        governing: dict[tuple[int, int], list[Any]],
        first: int,
        last: int,
        upstream_m: float,
    ) -> None:
        self._upstream_m = upstream_m
        self._graph, self._governing = graph, governing
        self._own = {lane_key(point.waypoint) for point in route[max(first - 30, 0) : last + 30]}
        self._before = {lane_key(point.waypoint) for point in route[max(first - 30, 0) : first]}
        inside = [lane_key(point.waypoint) for point in route[first : last + 1]]
        self._before |= graph.before(inside[0])
        self._junction_id = route[first].waypoint.junction_id
        self._line = line
        self.enter_s, leave_s = (_place(line, route, index) for index in (first, last))
        self._stretch = (line.s >= self.enter_s - 1.0) & (line.s <= leave_s + _BEYOND_M)
        self._yaw = line.yaw[self._stretch]
        self._turn, self._bend = _turn(self._yaw), float(np.abs(np.diff(self._yaw)).sum())

    def ways(self, stop_sign: bool) -> Iterator[ConflictPath]:
        """Yield those that cross or join the route, each with as much road before and behind as matters."""
        for key in self._graph.lanes_of_junction(self._junction_id):
            if key not in self._own and not self._graph.before(key) & self._before:
                way = self._way(key, stop_sign)
                if way is not None:
                    yield way

    def _way(self, key: LaneKey, stop_sign: bool) -> ConflictPath | None:
        first, last = self._indices(key)
        inside = np.array(self._graph.xy[first : last + 1])
        own_x, own_y = self._line.x[self._stretch], self._line.y[self._stretch]
        near = np.hypot(own_x[:, None] - inside[:, 0], own_y[:, None] - inside[:, 1]) < MEETS_M
        if not near.any():
            return None
        lanes = self._through(key)
        xy = np.concatenate([self._points(lane) for lane in lanes])
        kept = np.concatenate([[True], np.hypot(*np.diff(xy, axis=0).T) > 0.1])
        xy = xy[kept]
        step = np.diff(xy, axis=0)
        s = arc_lengths(xy)
        yaw = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
        yaw = np.append(yaw, yaw[-1])
        begins = nearest_index(xy, *inside[0])
        own_rows, columns = np.flatnonzero(near.any(axis=1)), np.flatnonzero(near.any(axis=0))
        meets = min(begins + int(columns[0]), len(s) - 1)
        parts = min(begins + int(columns[-1]), len(s) - 1)
        own_yaw = float(self._yaw[own_rows[0]])
        if math.cos(own_yaw - float(yaw[meets])) < _OPPOSED_COS and len(columns) > 0.8 * len(inside):
            return None  # the same lane, driven the other way
        own_s = self._line.s[self._stretch]
        through = yaw[begins : begins + len(inside)]
        kept = (s > s[begins] - self._upstream_m) & (s < s[parts] + DOWNSTREAM_M)
        joins = bool(near[:, -1].any()) and bool(self._graph.after(key) & self._own)
        return ConflictPath(
            x=xy[kept, 0],
            y=xy[kept, 1],
            yaw=yaw[kept],
            s=s[kept],
            inside_s=float(s[begins]),
            meets_s=float(s[meets]),
            parts_s=float(s[parts]),
            route_meets_s=float(own_s[own_rows[0]]),
            route_parts_s=float(own_s[own_rows[-1]]),
            straight=_turn(through) == "straight",
            bend_mps=_bend_mps(through),
            joins=joins,
            approach=lanes[max(lanes.index(key) - 1, 0)],
            goes_first=stop_sign or self._goes_first(through, joins),
            lights=tuple(light for lane in lanes for light in self._governing.get((lane[0], lane[2]), [])),
        )

    def _goes_first(self, through: Array, joins: bool) -> bool:
        rank = {"straight": 0, "right": 1, "left": 2}
        own, other = rank[self._turn], rank[_turn(through)]
        if own != other:
            return own > other
        if joins:
            return self._bend > float(np.abs(np.diff(through)).sum()) + _CLEARLY_RAD
        # CARLA's yaw grows clockwise: traffic from the right has a smaller one.
        comes = math.remainder(float(through[0] - self._yaw[0]), math.tau)
        return -math.pi + _FROM_THE_RIGHT_RAD < comes < -_FROM_THE_RIGHT_RAD

    def _through(self, key: LaneKey) -> list[LaneKey]:
        """Return the lanes of a way: up the road from its lane in the junction, and down behind it."""
        lanes = [key]
        for onward, reach in ((self._graph.before, self._upstream_m), (self._graph.after, DOWNSTREAM_M)):
            here, gone = key, 0.0
            while gone < reach and (options := onward(here) - set(lanes)):
                here = min(options, key=lambda option: abs(_turn_rad(self._yaws(option))))
                lanes.insert(0 if onward == self._graph.before else len(lanes), here)
                gone += float(self._indices(here)[1] - self._indices(here)[0])
        return lanes

    def _indices(self, key: LaneKey) -> tuple[int, int]:
        span = self._graph.span_of(key)
        assert span is not None
        return span

    def _points(self, key: LaneKey) -> Array:
        first, last = self._indices(key)
        return np.array(self._graph.xy[first : last + 1])

    def _yaws(self, key: LaneKey) -> Array:
        first, last = self._indices(key)
        ends = (self._graph.samples[first], self._graph.samples[last])
        return np.radians([end.transform.rotation.yaw for end in ends])


def _junction_stretches(route: Sequence[RoutePoint]) -> Iterator[tuple[int, int]]:
    """First and last index of each stretch of the route through one junction."""
    index = 0
    for junction, points in itertools.groupby(
        route, key=lambda point: point.waypoint.junction_id if point.waypoint.is_junction else None
    ):
        length = len(list(points))
        if junction is not None:
            yield index, index + length - 1
        index += length


def _place(line: Path, route: Sequence[RoutePoint], index: int) -> float:
    """Return the arc length on the line of a point of the route, searched near its own place if the route passes
    twice.
    """
    place, guess = route[index].waypoint.transform.location, index / max(len(route) - 1, 1) * line.length
    away = np.hypot(line.x - place.x, line.y - place.y) + 0.05 * np.abs(line.s - guess)
    return float(line.s[int(np.argmin(away))])


def _turn(yaw: Array) -> str:
    change = _turn_rad(yaw)
    if abs(change) < TURN_THRESHOLD_RAD:
        return "straight"
    return "right" if change > 0.0 else "left"


def _bend_mps(yaw: Array) -> float:
    """Return the speed at which the sharpest bend within some meters of a line needs `FASTEST_LATERAL_MPS2`."""
    over = min(_BEND_OVER, len(yaw) - 1)
    sharpest = float(np.abs(yaw[over:] - yaw[:-over]).max()) / over if over else 0.0
    return math.sqrt(FASTEST_LATERAL_MPS2 / max(sharpest, 1e-3))


def _turn_rad(yaw: Array) -> float:
    return math.remainder(float(yaw[-1] - yaw[0]), math.tau)
