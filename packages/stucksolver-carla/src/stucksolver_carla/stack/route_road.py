"""Reads the road along a route from the waypoint graph, once per route. Road geometries are slices of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from stucksolver.scene import LaneDirection, LaneKind, LaneStrip, RoadGeometry, Zone, ZoneKind
from stucksolver.scene.polyline import arc_lengths, distances, nearest_index
from stucksolver_carla.drivers.behavior import RoutePoint
from stucksolver_carla.stack.adjacent_lanes import AdjacentLane, adjacent_lanes
from stucksolver_carla.stack.carla_frames import to_local, yaw_to_local

if TYPE_CHECKING:
    import carla

SPACING_M = 2.0
"""Distance between two stations (m). Ours."""
FINE_SPACING_M = 0.25
"""Distance between two points of the fine line, on which stop signs are searched (m). Ours."""
BEHIND_M = 150.0
"""Length of the road behind the ego (m). The guard requires 144 m to enter a lane at 100 km/h."""
AHEAD_M = 320.0
"""Length of the road ahead of the ego (m). Ours."""
BEFORE_START_M = 120.0
"""Length of the road before the route's start (m), because a new route may start this far ahead of the ego."""
ON_ROUTE_M = 2.2
"""Maximum distance from the route to the waypoint of a stop line in the route's lane (m). Ours."""
HALF_WIDTH_M = 1.0
"""Distance from the route to the ego's side (m). A crosswalk within it crosses the ego's path. Ours."""
ANDREWS_CROSS = "201"
"""OpenDRIVE's signal type of the cross at a level crossing (StVO sign 201), as in CARLA's landmarks."""
CROSS_DISTANCE_M = 10.0
"""Maximum distance from the route to a cross whose level crossing is on the route (m). Ours."""
CROSS_HALF_LENGTH_M = 12.0
"""Length of a level crossing before and after its cross (m). Ours."""
AFTER_END_M = 80.0
"""Length of the road after the destination (m), so that a plan may end there. Ours."""


LAP_M, LAP_DISTANCE_M = 30.0, 1.5
"""Length of a lap, and distance to the route's earlier line, from which a route repeats a lap (m). Ours."""


@dataclass(frozen=True)
class Station:
    """One sample of the route: its waypoint and the adjacent lanes."""

    x: float
    y: float
    waypoint: carla.Waypoint
    junction: bool
    lanes: tuple[AdjacentLane, ...]


class RouteRoad:
    """The road along a route as stations every two meters, extended at both ends."""

    def __init__(self, carla_map: carla.Map, route: Sequence[RoutePoint]) -> None:
        waypoints = [p.waypoint for p in route]
        before = _lane_waypoints(waypoints[0], BEFORE_START_M, forward=False)[::-1]
        after = _lane_waypoints(waypoints[-1], AFTER_END_M, forward=True)
        line, arcs = _resampled([*before, *waypoints, *after])
        self.stations = tuple(_station(w, x, y, heading) for w, x, y, heading in line)
        self._lanes = _named_lanes(self.stations)
        self.start_arc, self.destination_arc = arcs[len(before)], arcs[len(before) + len(waypoints) - 1]
        """Arc lengths of the route's start and end (m)."""
        points = np.array([(s.x, s.y) for s in self.stations])
        self.arc = arc_lengths(points)
        self._points = points
        self._new_m = new_ground(points, self.arc)
        self._crosswalks = _crosswalk_spans(carla_map, points, self.arc)
        self._level_crossings = _level_crossing_spans(carla_map, points, self.arc)

    def arc_of(self, x: float, y: float, first: int, last: int) -> float:
        """Return the arc length of the point nearest to (x, y) between the stations `first` and `last` (m)."""
        k = nearest_index(self._points[max(first, 0) : last], x, y) + max(first, 0)
        j = min(k, len(self._points) - 2)
        direction = self._points[j + 1] - self._points[j]
        along = float(np.dot((x, y) - self._points[j], direction) / max(np.hypot(*direction), 1e-6))
        return float(self.arc[j]) + along

    def new_ground(self, arc_m: float) -> float:
        """Return the length of the route up to an arc length without repeated stretches (m)."""
        return float(np.interp(arc_m, self.arc, self._new_m))

    def crossing(self, transform: carla.Transform) -> float | None:
        """Return the arc length of a waypoint on the route in the route's direction (m); None if it is elsewhere."""
        x, y = to_local(transform.location)
        distances_m = distances(self._points, x, y)
        k = min(int(distances_m.argmin()), len(self._points) - 2)
        if distances_m[k] > ON_ROUTE_M:
            return None
        dx, dy = self._points[k + 1] - self._points[k]
        turn = math.remainder(yaw_to_local(transform.rotation.yaw) - math.atan2(dy, dx), math.tau)
        return self.arc_of(x, y, k - 2, k + 3) if abs(turn) < math.pi / 3 else None

    def fine_line(self) -> tuple[Any, Any, Any, Any]:
        """Return (arc length, x, y, z) of the route every quarter meter, in CARLA's world frame (m)."""
        arc = np.arange(0.0, float(self.arc[-1]), FINE_SPACING_M)
        x, y = (np.interp(arc, self.arc, column) for column in self._points.T)
        heights = [station.waypoint.transform.location.z for station in self.stations]
        return arc, x, -y, np.interp(arc, self.arc, heights)

    def slice(self, arc_m: float, speed_limit_mps: float | None) -> RoadGeometry:
        """Return the road geometry around an arc length, from `BEHIND_M` behind it to `AHEAD_M` ahead of it."""
        first = int(np.searchsorted(self.arc, arc_m - BEHIND_M))
        last = int(np.searchsorted(self.arc, arc_m + AHEAD_M))
        stations = self.stations[first:last]
        base = float(self.arc[first])
        end = float(self.arc[min(last, len(self.arc)) - 1])
        destination = self.destination_arc if self.destination_arc <= end else None
        zones = [*_junctions(stations, self.arc[first:last])]
        zones += [
            Zone(kind=kind, start_m=a, end_m=b)
            for kind, spans in (
                (ZoneKind.CROSSWALK, self._crosswalks),
                (ZoneKind.LEVEL_CROSSING, self._level_crossings),
            )
            for a, b in spans
            if b > base and a < end
        ]
        return RoadGeometry(
            key=f"{id(self)}-{first}-{last}-{speed_limit_mps}",
            spacing_m=SPACING_M,
            reference=tuple((round(s.x, 3), round(s.y, 3)) for s in stations),
            lanes=tuple(_strips(self._lanes[first:last], speed_limit_mps)),
            zones=tuple(zones),
            route_start_m=base,
            destination_m=destination,
        )


def _lane_waypoints(waypoint: carla.Waypoint, length_m: float, *, forward: bool) -> list[carla.Waypoint]:
    """Return waypoints every meter straight ahead (or back) along the lanes, up to the end of the road."""
    waypoints_along: list[Any] = []
    here = waypoint
    while len(waypoints_along) < length_m:
        following = here.next(1.0) if forward else here.previous(1.0)
        if not following:
            break
        yaw = here.transform.rotation.yaw
        here = min(following, key=lambda w: abs(math.remainder(w.transform.rotation.yaw - yaw, 360.0)))
        waypoints_along.append(here)
    return waypoints_along


def _resampled(waypoints: list[carla.Waypoint]) -> tuple[list[tuple[Any, float, float, float]], list[float]]:
    """Return (waypoint, x, y, heading) every `SPACING_M` along a line of waypoints, and the waypoints' arc lengths.

    The frame is the local one. At least two waypoints must have different positions.
    """
    points = np.array([to_local(w.transform.location) for w in waypoints])
    arc = arc_lengths(points)
    stations = np.arange(0.0, arc[-1] + 1e-6, SPACING_M)
    x, y = np.interp(stations, arc, points[:, 0]), np.interp(stations, arc, points[:, 1])
    heading = np.arctan2(np.gradient(y), np.gradient(x))
    nearest = np.clip(np.searchsorted(arc, stations), 0, len(waypoints) - 1)
    line = [(waypoints[k], float(a), float(b), float(h)) for k, a, b, h in zip(nearest, x, y, heading, strict=True)]
    return line, arc.tolist()


def _station(waypoint: carla.Waypoint, x: float, y: float, heading: float) -> Station:
    junction = bool(waypoint.is_junction)
    return Station(x, y, waypoint, junction, adjacent_lanes(waypoint, x, y, heading, only_own=junction))


def _named_lanes(stations: Sequence[Station]) -> list[list[tuple[str, AdjacentLane]]]:
    """Return the lanes of each station with their names. A name stays the same while the lane's place and kind do."""
    named: list[list[tuple[str, AdjacentLane]]] = []
    names_before: dict[str, str] = {}
    for i, station in enumerate(stations):
        names_here = {}
        for lane in station.lanes:
            place = _name(lane.place, lane.kind, lane.direction)
            names_here[place] = (names_before.get(place, f"{place}@{i * SPACING_M:.0f}"), lane)
        names_before = {place: name for place, (name, _) in names_here.items()}
        named.append(list(names_here.values()))
    return named


def _strips(stations: Sequence[Sequence[tuple[str, AdjacentLane]]], limit: float | None) -> list[LaneStrip]:
    """Return the named lanes of a range of stations as strips, from the route outward."""
    runs: dict[str, list[tuple[int, AdjacentLane]]] = {}
    for i, lanes in enumerate(stations):
        for name, lane in lanes:
            runs.setdefault(name, []).append((i, lane))
    strips = [
        LaneStrip(
            id=name,
            kind=run[0][1].kind,
            direction=run[0][1].direction,
            start=run[0][0],
            offset_m=tuple(round(lane.offset_m, 3) for _, lane in run),
            width_m=tuple(round(lane.width_m, 3) for _, lane in run),
            line=tuple(lane.line for _, lane in run),
            speed_limit_mps=limit if run[0][1].kind is LaneKind.DRIVING else None,
        )
        for name, run in runs.items()
    ]
    return sorted(strips, key=lambda s: abs(s.offset_m[0]))


def _name(number: int, kind: LaneKind, direction: LaneDirection) -> str:
    if number == 0:
        return "own"
    side = "left" if number > 0 else "right"
    kind_name = "oncoming" if direction is LaneDirection.OPPOSITE and kind is LaneKind.DRIVING else kind.value
    return f"{side}{abs(number)}-{kind_name}"


def _junctions(stations: Sequence[Station], arc: Any) -> list[Zone]:
    zones: list[Zone] = []
    start: float | None = None
    for i, station in enumerate(stations):
        if station.junction and start is None:
            start = float(arc[i])
        if not station.junction and start is not None:
            zones.append(Zone(kind=ZoneKind.JUNCTION, start_m=start, end_m=float(arc[i])))
            start = None
    if start is not None:
        zones.append(Zone(kind=ZoneKind.JUNCTION, start_m=start, end_m=float(arc[len(stations) - 1])))
    return zones


def _crosswalk_spans(carla_map: carla.Map, points: Any, arc: Any) -> list[tuple[float, float]]:
    """Return the spans of arc length in which the ego's box overlaps crosswalks, one per crossing (m)."""
    steps = shapely.linestrings(np.stack([points[:-1], points[1:]], axis=1))
    spans = []
    for polygon in _crosswalks(carla_map):
        crossed = np.flatnonzero(shapely.intersects(steps, polygon))
        for run in np.split(crossed, np.flatnonzero(np.diff(crossed) > 1) + 1) if len(crossed) else []:
            first, last = int(run[0]), int(run[-1]) + 1
            line = shapely.LineString(points[first : last + 1])
            ends = shapely.get_coordinates(line.intersection(polygon))
            along = [line.project(shapely.Point(end)) for end in ends]
            spans.append((float(arc[first] + min(along)), float(arc[first] + max(along))))
    return spans


def _level_crossing_spans(carla_map: carla.Map, points: Any, arc: Any) -> list[tuple[float, float]]:
    """Return the spans of arc length around St Andrew's crosses along the route (m). The tracks are close to them."""
    spans = []
    for landmark in carla_map.get_all_landmarks_of_type(ANDREWS_CROSS):
        x, y = to_local(landmark.transform.location)
        distances_m = distances(points, x, y)
        k = int(distances_m.argmin())
        if distances_m[k] < CROSS_DISTANCE_M:
            spans.append((float(arc[k]) - CROSS_HALF_LENGTH_M, float(arc[k]) + CROSS_HALF_LENGTH_M))
    return spans


def _crosswalks(carla_map: carla.Map) -> list[Any]:
    """Return the map's crosswalks as areas, enlarged by the ego's half width."""
    outlines: list[list[tuple[float, float]]] = [[]]
    for location in carla_map.get_crosswalks():
        point = to_local(location)
        outlines[-1].append(point)
        # The client lists polygons one after the other, each closed by its first point.
        if len(outlines[-1]) > 2 and outlines[-1][0] == point:
            outlines.append([])
    return [shapely.MultiPoint(outline).convex_hull.buffer(HALF_WIDTH_M) for outline in outlines if len(outline) > 2]


def new_ground(points: Any, arc: Any) -> np.ndarray[Any, Any]:
    """Return the arc length at each point of a line without its repeated stretches (m).

    `points` (n, 2) and `arc` (n,) in meters; the result is (n,). A lap of a roundabout counts once.
    """
    points_2d = shapely.points(points)
    later, earlier = shapely.STRtree(points_2d).query(points_2d, predicate="dwithin", distance=LAP_DISTANCE_M)
    is_repeated = later[arc[later] - arc[earlier] > LAP_M]
    steps = np.diff(arc, prepend=arc[0])
    steps[is_repeated] = 0.0
    return np.asarray(np.cumsum(steps) + arc[0])
