"""Other ways through the junction in which the ego stands, where a new route may begin."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import carla
import numpy as np
import shapely

from stucksolver.scene import EgoState, TrackedObject
from stucksolver.scene.polyline import nearest_index
from stucksolver_carla.drivers.behavior.routing import RouteError, trace_route
from stucksolver_carla.stack.carla_frames import to_local, yaw_to_local
from stucksolver_carla.stack.route_road import SPACING_M, RouteRoad

JOINS_M = (8.0, 11.0, 14.0, 18.0, 23.0, 28.0)
"""The ego may join another way up to this far ahead."""
KEPT_M = 0.3
"""Distance kept from standing objects on the way over."""
STANDS_MPS = 0.3
SAME_ROAD_M = 8.0
"""A route that comes this near (m) to the road ahead leads back to where the ego cannot go, ..."""
ROAD_FROM_M = 10.0
"""... from this distance beyond the junction (m) ..."""
ROAD_TO_M = 60.0
"""... to this one (m)."""
BEHIND_M = 6.0
BEYOND_M = 25.0
BETWEEN_M = 2.5
"""Half the width of the paved area between lanes that part (m)."""
OVER_EDGE_M = 0.15
"""How far the body may stick out over its edge (m)."""
SAMPLES = 25
Line = list["carla.Waypoint"]


@dataclass(frozen=True)
class AlternativeRoute:
    """`waypoint` is where the new route begins, `distance_m` from the ego in a straight line (m).

    `route_length_m` is the length from there to the destination (m); None if no route avoids the road ahead.
    """

    waypoint: carla.Waypoint
    turn: str
    distance_m: float
    route_length_m: float | None


def other_ways(
    carla_map: carla.Map,
    road: RouteRoad,
    arc_m: float,
    ego: EgoState,
    things: Sequence[TrackedObject],
    destination: Any,
) -> tuple[AlternativeRoute, ...]:
    """Return the ways that the ego can turn onto from where it stands, past the junction's stop line.

    They are within its turning circle, on the road surface, and clear of standing objects. Before the junction there
    are none, because a route that begins behind a stop line does not know that line.

    Args:
        carla_map: The map.
        road: The road along the present route.
        arc_m: The ego's arc length on it (m).
        ego: The ego in the local frame.
        things: Objects around it, in the local frame.
        destination: The `carla.Location` of the destination.
    """
    here = road.stations[min(int(arc_m / SPACING_M), len(road.stations) - 1)]
    if not here.junction:
        return ()
    first, last = _junction(road, arc_m)
    lines = list(_lines(road.stations[max(first - 1, 0)].waypoint))
    surface = _surface(here.waypoint.get_junction(), lines)
    standing = [_body(t.x_m, t.y_m, t.yaw_rad, t.length_m, t.width_m) for t in things if _stands(t)]
    found = []
    for line in lines:
        start = _start(carla_map, line, ego)
        mine = (line[0].road_id, line[0].lane_id) == (here.waypoint.road_id, here.waypoint.lane_id)
        if mine or start is None or not _reaches(line, ego, standing, surface):
            continue
        x, y = to_local(start.transform.location)
        length_m = route_length_m(carla_map, start, destination, road_ahead(road, last))
        found.append(AlternativeRoute(start, _turn(line), math.hypot(x - ego.x_m, y - ego.y_m), length_m))
    return tuple(found)


def destination_beside(
    carla_map: carla.Map, start: carla.Location, end: carla.Location, longest_m: float
) -> carla.Location | None:
    """Return the `carla.Location` at the destination that a route up to that length reaches, or None.

    The destination's own lane comes first, then those beside it. A vehicle past the last place to change back arrives
    beside the destination's lane and does not drive round the block.
    """
    for waypoint in _abreast_of(carla_map.get_waypoint(end)):
        try:
            # One point per meter.
            length_m = len(trace_route(carla_map, start, waypoint.transform.location))
        except RouteError:
            continue
        if length_m <= longest_m:
            return waypoint.transform.location
    return None


def _abreast_of(waypoint: carla.Waypoint) -> list[carla.Waypoint]:
    """Return a waypoint and those beside it in the same direction, from the nearest outward."""
    found = [waypoint]
    for step in ("get_left_lane", "get_right_lane"):
        beside = getattr(waypoint, step)()
        while beside is not None and beside.lane_type == carla.LaneType.Driving:
            if beside.lane_id * waypoint.lane_id < 0:
                break
            found.append(beside)
            beside = getattr(beside, step)()
    return found


def _junction(road: RouteRoad, arc_m: float) -> tuple[int, int]:
    """Return the first station of the ego's junction, and the first one after it."""
    first = last = min(int(arc_m / SPACING_M), len(road.stations) - 1)
    while first > 0 and road.stations[first - 1].junction:
        first -= 1
    while last < len(road.stations) and road.stations[last].junction:
        last += 1
    return first, last


def _lines(entry: carla.Waypoint) -> Iterator[Line]:
    """Yield each way through the junction from a waypoint just before it to a little beyond, one waypoint per meter."""
    heads = [entry]
    for _ in range(int(2 * SPACING_M) + 1):
        heads = [after for item in heads for after in ([item] if item.is_junction else item.next(1.0))]
    for head in heads:
        line, beyond = [head], 0.0
        while beyond < BEYOND_M:
            after = line[-1].next(1.0)
            if not after:
                break
            line.append(after[0])
            beyond += 0.0 if after[0].is_junction else 1.0
        if head.is_junction:
            yield line


def _start(carla_map: carla.Map, line: Line, ego: EgoState) -> carla.Waypoint | None:
    """Return the first waypoint ahead of the ego that is the nearest of all lanes at its own place."""
    for item in line[_abreast(line, ego) + 1 :]:
        seen = carla_map.get_waypoint(item.transform.location)
        if seen is not None and (seen.road_id, seen.lane_id) == (item.road_id, item.lane_id):
            return item
    return None


def _abreast(line: Line, ego: EgoState) -> int:
    places = np.array([to_local(item.transform.location) for item in line])
    return nearest_index(places, ego.x_m, ego.y_m)


def _reaches(line: Line, ego: EgoState, standing: Sequence[Any], surface: Any) -> bool:
    """True if the ego can join a way by one or two bends."""
    here = _abreast(line, ego)
    for ahead in (here + int(join) for join in JOINS_M):
        if ahead >= len(line):
            return False
        at = line[ahead].transform
        x, y, yaw = way_over((ego.x_m, ego.y_m, ego.yaw_rad), (*to_local(at.location), yaw_to_local(at.rotation.yaw)))
        if sharpest(x, y) > 1.0 / ego.limits.min_turn_radius_m:
            continue
        bodies = [_body(a, b, c, ego.length_m, ego.width_m) for a, b, c in zip(x, y, yaw, strict=True)]
        swept = shapely.union_all(bodies)
        if surface.covers(swept) and not any(swept.distance(obj) < KEPT_M for obj in standing):
            return True
    return False


def _surface(junction: Any, lines: Sequence[Line]) -> Any:
    """Return all lanes of a junction, the area between them, and the lanes into and out of it."""
    paths = [*lines, *(_inside(begin) for begin, _ in junction.get_waypoints(carla.LaneType.Driving))]
    strips = [
        shapely.LineString([to_local(item.transform.location) for item in path]).buffer(
            max(item.lane_width for item in path) / 2, cap_style="flat"
        )
        for path in paths
        if len(path) > 1
    ]
    return shapely.union_all(strips).buffer(BETWEEN_M).buffer(OVER_EDGE_M - BETWEEN_M)


def _inside(begin: Any) -> Line:
    """Return a lane through a junction, from a little before it to just after it."""
    path = [*begin.previous(BEHIND_M)[:1], begin]
    while path[-1].is_junction:
        after = path[-1].next(1.0)
        if not after:
            break
        path.append(after[0])
    return path


def way_over(start: tuple[float, float, float], end: tuple[float, float, float]) -> tuple[Any, Any, Any]:
    """Return x, y and heading along the cubic Hermite curve from one (x, y, heading) to another (m, rad)."""
    u = np.linspace(0.0, 1.0, SAMPLES)
    reach = math.hypot(end[0] - start[0], end[1] - start[1])
    blend = (2 * u**3 - 3 * u**2 + 1, u**3 - 2 * u**2 + u, 3 * u**2 - 2 * u**3, u**3 - u**2)
    tangents = [(reach * math.cos(item[2]), reach * math.sin(item[2])) for item in (start, end)]
    x, y = (
        blend[0] * start[k] + blend[1] * tangents[0][k] + blend[2] * end[k] + blend[3] * tangents[1][k] for k in (0, 1)
    )
    return x, y, np.arctan2(np.gradient(y), np.gradient(x))


def sharpest(x: Any, y: Any) -> float:
    """Return the greatest curvature along a line (1/m)."""
    dx, dy = np.gradient(x), np.gradient(y)
    bend = np.abs(dx * np.gradient(dy) - dy * np.gradient(dx)) / np.maximum(np.hypot(dx, dy), 1e-6) ** 3
    return float(bend.max())


def _body(x: float, y: float, yaw: float, length: float, width: float) -> Any:
    box = shapely.box(-length / 2, -width / 2, length / 2, width / 2)
    corners = shapely.get_coordinates(box)[:4]
    c, n = math.cos(yaw), math.sin(yaw)
    return shapely.Polygon(corners @ np.array([[c, n], [-n, c]]) + (x, y))


def _stands(thing: TrackedObject) -> bool:
    return math.hypot(thing.vx_mps, thing.vy_mps) < STANDS_MPS


def road_ahead(road: RouteRoad, after: int) -> Any:
    """Return (x, y) of the present route a little beyond a station, for example the first one after the junction."""
    part = road.stations[after + int(ROAD_FROM_M / SPACING_M) : after + int(ROAD_TO_M / SPACING_M)]
    return shapely.MultiPoint([(item.x, item.y) for item in part])


def route_length_m(carla_map: carla.Map, start: Any, destination: Any, shut: Any) -> float | None:
    """Return the route length from a waypoint to a `carla.Location` (m); None if there is no route that avoids
    `shut`.
    """
    try:
        route = trace_route(carla_map, start.transform.location, destination)
    except RouteError:
        return None
    line = shapely.LineString([to_local(item.waypoint.transform.location) for item in route])
    comes_back = not shut.is_empty and line.distance(shut) < SAME_ROAD_M
    return None if comes_back else float(line.length)


def _turn(line: Line) -> str:
    yaws = [item.transform.rotation.yaw for item in line]
    # CARLA's yaw grows clockwise.
    angle = math.remainder(yaws[-1] - yaws[0], 360.0)
    return "straight" if abs(angle) < 33.0 else ("right" if angle > 0.0 else "left")
