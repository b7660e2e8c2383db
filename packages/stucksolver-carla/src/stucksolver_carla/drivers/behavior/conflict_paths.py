"""Finds the conflict paths of a route at its junctions, once per route, from the lane graph.

The frame is CARLA's world frame (m, rad).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stucksolver.scene.polyline import arc_lengths, nearest_index
from stucksolver_bridge.traffic_side import drives_on_left
from stucksolver_carla.drivers.behavior.lane_graph import LaneGraph, LaneKey, lane_key
from stucksolver_carla.drivers.behavior.path import Array, Path
from stucksolver_carla.drivers.behavior.routing import TURN_THRESHOLD_RAD
from stucksolver_carla.drivers.driver_interface import RoutePoint

if TYPE_CHECKING:
    import carla

CONFLICT_M = 2.2
"""Distance between center lines below which two cars cannot drive on both at once (m): two half widths and 0.1 m."""
UPSTREAM_M = 90.0
"""Length of a conflict path before the junction (m). Ours."""
DOWNSTREAM_M = 40.0
"""Length of a conflict path after the conflict (m). Ours."""
FASTEST_LATERAL_MPS2 = 6.0
"""Maximum lateral acceleration of other vehicles in a bend (m/s²). Ours; about the grip of a wet road (0.6 g)."""
_BEND_SAMPLES = 4
"""Number of samples, about one meter apart, over which a bend's curvature is measured. Ours."""
_AFTER_M = 8.0
"""Length of the route after the junction in which conflicts count (m). Ours."""
_OPPOSITE_COS = math.cos(math.radians(150.0))
"""Cosine of the angle from which two lanes have opposite directions. Ours."""
_BEND_MARGIN_RAD = 0.05
"""Difference of the total bend from which one of two joining paths bends more (rad). Ours."""
_FROM_RIGHT_RAD = math.radians(30.0)
"""Minimum angle to the route of traffic from the right (rad). Ours."""


@dataclass(frozen=True, eq=False)
class ConflictPath:
    """A path through a junction that crosses or joins the route; samples about a meter apart, upstream first."""

    x: Array
    y: Array
    yaw: Array
    s: Array
    """Arc lengths along the path (m)."""
    inside_s: float
    """Arc length at which the path enters the junction (m)."""
    meets_s: float
    """Arc length at which the conflict with the route starts (m)."""
    parts_s: float
    """Arc length at which the conflict ends (m); the end of the junction if the path joins the route."""
    route_meets_s: float
    """Arc length of the route's line at which the conflict starts (m)."""
    route_parts_s: float
    """Arc length of the route's line at which the conflict ends (m)."""
    straight: bool
    """True if the path goes straight through the junction."""
    bend_mps: float
    """Maximum speed in the path's bend (m/s)."""
    joins: bool
    """True if the path continues along the route instead of crossing it."""
    approach: LaneKey
    """The lane that leads to the junction."""
    goes_first: bool
    """True if the path has the right of way over the route, without regard to lights."""
    lights: tuple[carla.TrafficLight, ...]
    """The `carla.TrafficLight`s of the path."""


@dataclass(frozen=True, eq=False)
class JunctionConflicts:
    """One junction of the route: the waiting place before it (arc length, m) and its conflict paths."""

    wait_s: float
    ways: tuple[ConflictPath, ...]

    @property
    def first_s(self) -> float:
        """Arc length of the route at which the first conflict starts (m)."""
        return min(way.route_meets_s for way in self.ways)

    @property
    def last_s(self) -> float:
        """Arc length of the route at which the last conflict ends (m)."""
        return max(way.route_parts_s for way in self.ways)


def junction_conflicts(
    route: Sequence[RoutePoint],
    line: Path,
    graph: LaneGraph,
    lights: Sequence[carla.TrafficLight],
    stops_s: Sequence[float],
    upstream_m: float = UPSTREAM_M,
) -> list[JunctionConflicts]:
    """Return the junctions of a route with conflict paths.

    Turning traffic yields to straight traffic, and left turns yield to all. If both paths turn alike, the one that
    bends more yields where they join, and the one that has the other on its right yields where they cross. After a stop
    sign all other paths have priority. In left-hand traffic, left and right are swapped.

    Args:
        route: The route.
        line: The route's path.
        graph: The lane graph.
        lights: The map's `carla.TrafficLight`s.
        stops_s: Arc lengths of the route's stop signs on the line (m).
        upstream_m: Length of the conflict paths before the junction (m).
    """
    lights_of_lane: dict[tuple[int, int], list[Any]] = {}
    for light in lights:
        for waypoint in light.get_stop_waypoints():
            lights_of_lane.setdefault((waypoint.road_id, waypoint.lane_id), []).append(light)
    junctions = []
    for first, last in _junction_stretches(route):
        junction = _Junction(route, line, graph, lights_of_lane, first, last, upstream_m)
        stop_sign = any(-15.0 < junction.enter_s - s < 15.0 for s in stops_s)
        ways = tuple(way for way in junction.ways(stop_sign))
        if ways:
            junctions.append(JunctionConflicts(junction.enter_s, ways))
    return junctions


class _Junction:
    """One stretch of the route through a junction, and the other paths through that junction."""

    def __init__(
        self,
        route: Sequence[RoutePoint],
        line: Path,
        graph: LaneGraph,
        lights_of_lane: dict[tuple[int, int], list[Any]],
        first: int,
        last: int,
        upstream_m: float,
    ) -> None:
        self._upstream_m = upstream_m
        self._graph, self._lights_of_lane = graph, lights_of_lane
        self._own_lanes = {lane_key(point.waypoint) for point in route[max(first - 30, 0) : last + 30]}
        self._entry_lanes = {lane_key(point.waypoint) for point in route[max(first - 30, 0) : first]}
        inside = [lane_key(point.waypoint) for point in route[first : last + 1]]
        self._entry_lanes |= graph.before(inside[0])
        self._junction_id = route[first].waypoint.junction_id
        self._is_left_hand = drives_on_left(route[first].waypoint)
        self._line = line
        self.enter_s, leave_s = (_arc_length_of(line, route, index) for index in (first, last))
        self._stretch = (line.s >= self.enter_s - 1.0) & (line.s <= leave_s + _AFTER_M)
        self._yaw = line.yaw[self._stretch]
        self._turn, self._bend = _turn(self._yaw), float(np.abs(np.diff(self._yaw)).sum())

    def ways(self, stop_sign: bool) -> Iterator[ConflictPath]:
        """Yield the paths that cross or join the route, each with its road before and after the junction."""
        for key in self._graph.lanes_of_junction(self._junction_id):
            if key not in self._own_lanes and not self._graph.before(key) & self._entry_lanes:
                conflict_path = self._conflict_path(key, stop_sign)
                if conflict_path is not None:
                    yield conflict_path

    def _conflict_path(self, key: LaneKey, stop_sign: bool) -> ConflictPath | None:
        first, last = self._indices(key)
        inside = np.array(self._graph.xy[first : last + 1])
        own_x, own_y = self._line.x[self._stretch], self._line.y[self._stretch]
        is_near = np.hypot(own_x[:, None] - inside[:, 0], own_y[:, None] - inside[:, 1]) < CONFLICT_M
        if not is_near.any():
            return None
        lanes = self._lanes_through(key)
        xy = np.concatenate([self._points(lane) for lane in lanes])
        is_kept = np.concatenate([[True], np.hypot(*np.diff(xy, axis=0).T) > 0.1])
        xy = xy[is_kept]
        step = np.diff(xy, axis=0)
        s = arc_lengths(xy)
        yaw = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
        yaw = np.append(yaw, yaw[-1])
        begins_at = nearest_index(xy, *inside[0])
        own_rows, columns = np.flatnonzero(is_near.any(axis=1)), np.flatnonzero(is_near.any(axis=0))
        meets_at = min(begins_at + int(columns[0]), len(s) - 1)
        parts_at = min(begins_at + int(columns[-1]), len(s) - 1)
        own_yaw = float(self._yaw[own_rows[0]])
        if math.cos(own_yaw - float(yaw[meets_at])) < _OPPOSITE_COS and len(columns) > 0.8 * len(inside):
            return None  # the same lane in the opposite direction
        own_s = self._line.s[self._stretch]
        through = yaw[begins_at : begins_at + len(inside)]
        is_kept = (s > s[begins_at] - self._upstream_m) & (s < s[parts_at] + DOWNSTREAM_M)
        joins = bool(is_near[:, -1].any()) and bool(self._graph.after(key) & self._own_lanes)
        return ConflictPath(
            x=xy[is_kept, 0],
            y=xy[is_kept, 1],
            yaw=yaw[is_kept],
            s=s[is_kept],
            inside_s=float(s[begins_at]),
            meets_s=float(s[meets_at]),
            parts_s=float(s[parts_at]),
            route_meets_s=float(own_s[own_rows[0]]),
            route_parts_s=float(own_s[own_rows[-1]]),
            straight=_turn(through) == "straight",
            bend_mps=_bend_mps(through),
            joins=joins,
            approach=lanes[max(lanes.index(key) - 1, 0)],
            goes_first=stop_sign or self._has_priority(through, joins),
            lights=tuple(light for lane in lanes for light in self._lights_of_lane.get((lane[0], lane[2]), [])),
        )

    def _has_priority(self, through: Array, joins: bool) -> bool:
        rank = {"straight": 0, "left": 1, "right": 2} if self._is_left_hand else {"straight": 0, "right": 1, "left": 2}
        own, other = rank[self._turn], rank[_turn(through)]
        if own != other:
            return own > other
        if joins:
            return self._bend > float(np.abs(np.diff(through)).sum()) + _BEND_MARGIN_RAD
        # CARLA's yaw grows clockwise: traffic from the right has a smaller one.
        angle = math.remainder(float(through[0] - self._yaw[0]), math.tau)
        angle = -angle if self._is_left_hand else angle
        return -math.pi + _FROM_RIGHT_RAD < angle < -_FROM_RIGHT_RAD

    def _lanes_through(self, key: LaneKey) -> list[LaneKey]:
        """Return the lanes of a path: before its lane in the junction, that lane, and after it."""
        lanes = [key]
        for neighbors_of, reach in ((self._graph.before, self._upstream_m), (self._graph.after, DOWNSTREAM_M)):
            lane, length_m = key, 0.0
            while length_m < reach and (options := neighbors_of(lane) - set(lanes)):
                lane = min(options, key=lambda option: abs(_turn_rad(self._yaws(option))))
                lanes.insert(0 if neighbors_of == self._graph.before else len(lanes), lane)
                length_m += float(self._indices(lane)[1] - self._indices(lane)[0])
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
    """Yield the first and last index of each stretch of the route through one junction."""
    index = 0
    for junction, points in itertools.groupby(
        route, key=lambda point: point.waypoint.junction_id if point.waypoint.is_junction else None
    ):
        length = len(list(points))
        if junction is not None:
            yield index, index + length - 1
        index += length


def _arc_length_of(line: Path, route: Sequence[RoutePoint], index: int) -> float:
    """Return the arc length on the line of a point of the route (m).

    Points near the expected arc length are preferred, because the route may pass the same position twice.
    """
    location, guess = route[index].waypoint.transform.location, index / max(len(route) - 1, 1) * line.length
    distance_m = np.hypot(line.x - location.x, line.y - location.y) + 0.05 * np.abs(line.s - guess)
    return float(line.s[int(np.argmin(distance_m))])


def _turn(yaw: Array) -> str:
    change = _turn_rad(yaw)
    if abs(change) < TURN_THRESHOLD_RAD:
        return "straight"
    return "right" if change > 0.0 else "left"


def _bend_mps(yaw: Array) -> float:
    """Return the speed at which the sharpest bend of a line requires `FASTEST_LATERAL_MPS2` (m/s)."""
    span = min(_BEND_SAMPLES, len(yaw) - 1)
    curvature = float(np.abs(yaw[span:] - yaw[:-span]).max()) / span if span else 0.0
    return math.sqrt(FASTEST_LATERAL_MPS2 / max(curvature, 1e-3))


def _turn_rad(yaw: Array) -> float:
    return math.remainder(float(yaw[-1] - yaw[0]), math.tau)
