"""The road along a route, read once from the waypoint graph for each route; episodes take slices of it."""

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
from stucksolver_carla.stack.adjacent_lanes import AdjacentLane, neighbours
from stucksolver_carla.stack.carla_frames import to_local, yaw_to_local

if TYPE_CHECKING:
    import carla

SPACING_M = 2.0
FINE_M = 0.25
BEHIND_M = 150.0
"""How far the road is known behind the ego: as far as the guard asks for at 100 km/h, to enter a lane (144 m)."""
AHEAD_M = 320.0
RUN_UP_M = 120.0
"""How far the road is known before the route: a new route may begin this far ahead of the ego."""
ON_ROUTE_M = 2.2
"""A stop line's waypoint this near to a station belongs to the route's lane."""
BODY_M = 1.0
"""From the route to the ego's side: a crosswalk this near is on its way."""
ANDREWS_CROSS = "201"
"""OpenDRIVE's signal type of the cross at a level crossing (StVO sign 201), as CARLA's landmarks carry it."""
CROSS_BESIDE_M = 10.0
CROSS_TRACKS_M = 12.0
BEYOND_M = 80.0
"""How far the road is known past the destination, so that a plan may end there."""


LAP_M, SAME_PLACE_M = 30.0, 1.5
"""A route that comes back after this distance to within this distance of its own line goes in a circle."""


@dataclass(frozen=True)
class Station:
    """One sample of the route: its waypoint and the lanes beside it."""

    x: float
    y: float
    waypoint: carla.Waypoint
    junction: bool
    lanes: tuple[AdjacentLane, ...]


class RouteRoad:
    """Stations every two meters along a route, extended a little at both ends."""

    def __init__(self, carla_map: carla.Map, route: Sequence[RoutePoint]) -> None:
        waypoints = [p.waypoint for p in route]
        before = _prolonged(waypoints[0], RUN_UP_M, forward=False)[::-1]
        after = _prolonged(waypoints[-1], BEYOND_M, forward=True)
        line, arcs = _resampled([*before, *waypoints, *after])
        self.stations = tuple(_station(w, x, y, heading) for w, x, y, heading in line)
        self._lanes = _named(self.stations)
        self.start_arc, self.destination_arc = arcs[len(before)], arcs[len(before) + len(waypoints) - 1]
        """Arc lengths at which the route itself begins and ends."""
        points = np.array([(s.x, s.y) for s in self.stations])
        self.arc = arc_lengths(points)
        self._points = points
        self._new_m = new_ground(points, self.arc)
        self._crosswalks = _crosswalk_spans(carla_map, points, self.arc)
        self._level_crossings = _level_crossing_spans(carla_map, points, self.arc)

    def arc_of(self, x: float, y: float, first: int, last: int) -> float:
        """Return the arc length of the point of stations `first` to `last` that is nearest to a place (m)."""
        k = nearest_index(self._points[max(first, 0) : last], x, y) + max(first, 0)
        j = min(k, len(self._points) - 2)
        direction = self._points[j + 1] - self._points[j]
        along = float(np.dot((x, y) - self._points[j], direction) / max(np.hypot(*direction), 1e-6))
        return float(self.arc[j]) + along

    def new_ground(self, arc_m: float) -> float:
        """Return how much of the route up to an arc length is on ground that it has not covered before (m)."""
        return float(np.interp(arc_m, self.arc, self._new_m))

    def crossing(self, transform: carla.Transform) -> float | None:
        """Return the arc length at which a lane's waypoint lies on the route in its direction, or None."""
        x, y = to_local(transform.location)
        away = distances(self._points, x, y)
        k = min(int(away.argmin()), len(self._points) - 2)
        if away[k] > ON_ROUTE_M:
            return None
        dx, dy = self._points[k + 1] - self._points[k]
        turn = math.remainder(yaw_to_local(transform.rotation.yaw) - math.atan2(dy, dx), math.tau)
        return self.arc_of(x, y, k - 2, k + 3) if abs(turn) < math.pi / 3 else None

    def fine_line(self) -> tuple[Any, Any, Any, Any]:
        """(arc length, x, y, z) of the route every quarter meter, in CARLA's world."""
        arc = np.arange(0.0, float(self.arc[-1]), FINE_M)
        x, y = (np.interp(arc, self.arc, column) for column in self._points.T)
        heights = [station.waypoint.transform.location.z for station in self.stations]
        return arc, x, -y, np.interp(arc, self.arc, heights)

    def slice(self, arc_m: float, speed_limit_mps: float | None) -> RoadGeometry:
        """Return the geometry around a place, for one episode."""
        first = int(np.searchsorted(self.arc, arc_m - BEHIND_M))
        last = int(np.searchsorted(self.arc, arc_m + AHEAD_M))
        part = self.stations[first:last]
        base = float(self.arc[first])
        end = float(self.arc[min(last, len(self.arc)) - 1])
        destination = self.destination_arc if self.destination_arc <= end else None
        zones = [*_junctions(part, self.arc[first:last])]
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
            reference=tuple((round(s.x, 3), round(s.y, 3)) for s in part),
            lanes=tuple(_strips(self._lanes[first:last], speed_limit_mps)),
            zones=tuple(zones),
            route_start_m=base,
            destination_m=destination,
        )


def _prolonged(waypoint: carla.Waypoint, length_m: float, *, forward: bool) -> list[carla.Waypoint]:
    """Return waypoints every meter straight on (or back) along the lanes, as long as there are any."""
    found: list[Any] = []
    here = waypoint
    while len(found) < length_m:
        following = here.next(1.0) if forward else here.previous(1.0)
        if not following:
            break
        yaw = here.transform.rotation.yaw
        here = min(following, key=lambda w: abs(math.remainder(w.transform.rotation.yaw - yaw, 360.0)))
        found.append(here)
    return found


def _resampled(waypoints: list[carla.Waypoint]) -> tuple[list[tuple[Any, float, float, float]], list[float]]:
    """Return (waypoint, x, y, heading) every `SPACING_M` along the line through waypoints, with their arc lengths.

    In the local frame. There must be two waypoints at different places.
    """
    points = np.array([to_local(w.transform.location) for w in waypoints])
    arc = arc_lengths(points)
    at = np.arange(0.0, arc[-1] + 1e-6, SPACING_M)
    x, y = np.interp(at, arc, points[:, 0]), np.interp(at, arc, points[:, 1])
    heading = np.arctan2(np.gradient(y), np.gradient(x))
    nearest = np.clip(np.searchsorted(arc, at), 0, len(waypoints) - 1)
    line = [(waypoints[k], float(a), float(b), float(h)) for k, a, b, h in zip(nearest, x, y, heading, strict=True)]
    return line, arc.tolist()


def _station(waypoint: carla.Waypoint, x: float, y: float, heading: float) -> Station:
    junction = bool(waypoint.is_junction)
    return Station(x, y, waypoint, junction, neighbours(waypoint, x, y, heading, alone=junction))


def _named(stations: Sequence[Station]) -> list[list[tuple[str, AdjacentLane]]]:
    """Return the lanes of each station with a name that stays the same while a lane keeps its place."""
    named: list[list[tuple[str, AdjacentLane]]] = []
    before: dict[str, str] = {}
    for i, station in enumerate(stations):
        here = {}
        for lane in station.lanes:
            place = _name(lane.place, lane.kind, lane.direction)
            here[place] = (before.get(place, f"{place}@{i * SPACING_M:.0f}"), lane)
        before = {place: name for place, (name, _) in here.items()}
        named.append(list(here.values()))
    return named


def _strips(part: Sequence[Sequence[tuple[str, AdjacentLane]]], limit: float | None) -> list[LaneStrip]:
    """Return runs of stations in which a lane keeps its place beside the route, as strips, from the route outward."""
    runs: dict[str, list[tuple[int, AdjacentLane]]] = {}
    for i, lanes in enumerate(part):
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


def _name(place: int, kind: LaneKind, direction: LaneDirection) -> str:
    if place == 0:
        return "own"
    side = "left" if place > 0 else "right"
    what = "oncoming" if direction is LaneDirection.OPPOSITE and kind is LaneKind.DRIVING else kind.value
    return f"{side}{abs(place)}-{what}"


def _junctions(part: Sequence[Station], arc: Any) -> list[Zone]:
    zones: list[Zone] = []
    start: float | None = None
    for i, station in enumerate(part):
        if station.junction and start is None:
            start = float(arc[i])
        if not station.junction and start is not None:
            zones.append(Zone(kind=ZoneKind.JUNCTION, start_m=start, end_m=float(arc[i])))
            start = None
    if start is not None:
        zones.append(Zone(kind=ZoneKind.JUNCTION, start_m=start, end_m=float(arc[len(part) - 1])))
    return zones


def _crosswalk_spans(carla_map: carla.Map, points: Any, arc: Any) -> list[tuple[float, float]]:
    """Return where the ego's body meets crosswalks of the map, as one span of arc length per crossing (m)."""
    steps = shapely.linestrings(np.stack([points[:-1], points[1:]], axis=1))
    spans = []
    for polygon in _crosswalks(carla_map):
        met = np.flatnonzero(shapely.intersects(steps, polygon))
        for run in np.split(met, np.flatnonzero(np.diff(met) > 1) + 1) if len(met) else []:
            first, last = int(run[0]), int(run[-1]) + 1
            line = shapely.LineString(points[first : last + 1])
            ends = shapely.get_coordinates(line.intersection(polygon))
            along = [line.project(shapely.Point(end)) for end in ends]
            spans.append((float(arc[first] + min(along)), float(arc[first] + max(along))))
    return spans


def _level_crossing_spans(carla_map: carla.Map, points: Any, arc: Any) -> list[tuple[float, float]]:
    """Return where the route passes St Andrew's crosses, as spans of arc length (m); tracks are close on either
    side.
    """
    spans = []
    for landmark in carla_map.get_all_landmarks_of_type(ANDREWS_CROSS):
        x, y = to_local(landmark.transform.location)
        away = distances(points, x, y)
        k = int(away.argmin())
        if away[k] < CROSS_BESIDE_M:
            spans.append((float(arc[k]) - CROSS_TRACKS_M, float(arc[k]) + CROSS_TRACKS_M))
    return spans


def _crosswalks(carla_map: carla.Map) -> list[Any]:
    """The map's crosswalks as areas, a little wider than they are painted."""
    outlines: list[list[tuple[float, float]]] = [[]]
    for location in carla_map.get_crosswalks():
        place = to_local(location)
        outlines[-1].append(place)
        # The client lists polygons one after the other, each closed by its first point.
        if len(outlines[-1]) > 2 and outlines[-1][0] == place:
            outlines.append([])
    return [shapely.MultiPoint(outline).convex_hull.buffer(BODY_M) for outline in outlines if len(outline) > 2]


def new_ground(points: Any, arc: Any) -> np.ndarray[Any, Any]:
    """Return the arc length at each point of a line without the stretches that it covers again (m).

    `points` (n, 2) and `arc` (n,) in meters; the result is (n,). A lap of a roundabout counts once.
    """
    places = shapely.points(points)
    here, there = shapely.STRtree(places).query(places, predicate="dwithin", distance=SAME_PLACE_M)
    again = here[arc[here] - arc[there] > LAP_M]
    steps = np.diff(arc, prepend=arc[0])
    steps[again] = 0.0
    return np.asarray(np.cumsum(steps) + arc[0])
