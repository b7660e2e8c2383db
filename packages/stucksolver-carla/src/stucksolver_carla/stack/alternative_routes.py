"""Finds other connections through the junction in which the ego has stopped, where a new route may start."""

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

JOIN_DISTANCES_M = (8.0, 11.0, 14.0, 18.0, 23.0, 28.0)
"""Distances along another connection, from the point abreast of the ego, at which the ego may join it (m). Ours."""
CLEARANCE_M = 0.3
"""Clearance to stopped objects while joining (m). Ours."""
STOPPED_MPS = 0.3
"""Speed below which an object counts as stopped (m/s). Ours."""
SAME_ROAD_M = 8.0
"""Distance to the present route's road below which a new route counts as leading back to it (m). Ours."""
ROAD_FROM_M = 10.0
"""Start of the present route's road that a new route must avoid, from the end of the junction (m). Ours."""
ROAD_TO_M = 60.0
"""End of the present route's road that a new route must avoid, from the end of the junction (m). Ours."""
ENTRY_M = 6.0
"""Length of a lane before the junction that counts as road surface (m). Ours."""
EXIT_M = 25.0
"""Length of a connection's lane after the junction (m). Ours."""
HALF_GAP_M = 2.5
"""Half the width of the paved area between diverging lanes (m). Ours."""
OVERHANG_M = 0.15
"""Distance by which the ego's box may extend beyond the road surface (m). Ours."""
SAMPLES = 25
"""Number of points of the curve to another connection. Ours."""
Line = list["carla.Waypoint"]


@dataclass(frozen=True)
class AlternativeRoute:
    """A route that starts at `waypoint`, at a straight-line distance of `distance_m` from the ego (m).

    `route_length_m` is the length from there to the destination (m); None if no route avoids the road ahead.
    """

    waypoint: carla.Waypoint
    turn: str
    distance_m: float
    route_length_m: float | None


def junction_alternatives(
    carla_map: carla.Map,
    road: RouteRoad,
    arc_m: float,
    ego: EgoState,
    objects: Sequence[TrackedObject],
    destination: Any,
) -> tuple[AlternativeRoute, ...]:
    """Return the connections that the ego can join from its position inside a junction.

    The curve to each is within the ego's turning circle, on the road surface, and clear of stopped objects. Before the
    junction the result is empty, because a route that starts after a stop line does not contain that line.

    Args:
        carla_map: The map.
        road: The road along the present route.
        arc_m: The ego's arc length on it (m).
        ego: The ego in the local frame.
        objects: Objects around the ego, in the local frame.
        destination: The `carla.Location` of the destination.
    """
    here = road.stations[min(int(arc_m / SPACING_M), len(road.stations) - 1)]
    if not here.junction:
        return ()
    first, last = _junction_stations(road, arc_m)
    lines = list(_junction_lines(road.stations[max(first - 1, 0)].waypoint))
    surface = _surface(here.waypoint.get_junction(), lines)
    stopped = [_footprint(t.x_m, t.y_m, t.yaw_rad, t.length_m, t.width_m) for t in objects if _is_stopped(t)]
    alternatives = []
    for line in lines:
        start = _start_waypoint(carla_map, line, ego)
        is_own = (line[0].road_id, line[0].lane_id) == (here.waypoint.road_id, here.waypoint.lane_id)
        if is_own or start is None or not _can_join(line, ego, stopped, surface):
            continue
        x, y = to_local(start.transform.location)
        length_m = route_length_m(carla_map, start, destination, road_ahead(road, last))
        alternatives.append(AlternativeRoute(start, _turn(line), math.hypot(x - ego.x_m, y - ego.y_m), length_m))
    return tuple(alternatives)


def reachable_destination(
    carla_map: carla.Map, start: carla.Location, end: carla.Location, longest_m: float
) -> carla.Location | None:
    """Return a `carla.Location` at the destination that a route up to `longest_m` reaches; None without one.

    The destination's own lane comes first, then its parallel lanes. So an ego that can no longer change lanes arrives
    next to the destination and does not drive around the block.
    """
    for waypoint in _parallel_waypoints(carla_map.get_waypoint(end)):
        try:
            # One point per meter.
            length_m = len(trace_route(carla_map, start, waypoint.transform.location))
        except RouteError:
            # No route leads to this lane. The next one may be reachable.
            continue
        if length_m <= longest_m:
            return waypoint.transform.location
    return None


def _parallel_waypoints(waypoint: carla.Waypoint) -> list[carla.Waypoint]:
    """Return a waypoint and those of its parallel lanes in the same direction, from the nearest outward."""
    alternatives = [waypoint]
    for step in ("get_left_lane", "get_right_lane"):
        next_lane = getattr(waypoint, step)()
        while next_lane is not None and next_lane.lane_type == carla.LaneType.Driving:
            if next_lane.lane_id * waypoint.lane_id < 0:
                break
            alternatives.append(next_lane)
            next_lane = getattr(next_lane, step)()
    return alternatives


def _junction_stations(road: RouteRoad, arc_m: float) -> tuple[int, int]:
    """Return the first station of the ego's junction, and the first one after it."""
    first = last = min(int(arc_m / SPACING_M), len(road.stations) - 1)
    while first > 0 and road.stations[first - 1].junction:
        first -= 1
    while last < len(road.stations) and road.stations[last].junction:
        last += 1
    return first, last


def _junction_lines(entry: carla.Waypoint) -> Iterator[Line]:
    """Yield each connection through the junction with a waypoint per meter, from `entry` to `EXIT_M` after it."""
    heads = [entry]
    for _ in range(int(2 * SPACING_M) + 1):
        heads = [after for item in heads for after in ([item] if item.is_junction else item.next(1.0))]
    for head in heads:
        line, beyond = [head], 0.0
        while beyond < EXIT_M:
            after = line[-1].next(1.0)
            if not after:
                break
            line.append(after[0])
            beyond += 0.0 if after[0].is_junction else 1.0
        if head.is_junction:
            yield line


def _start_waypoint(carla_map: carla.Map, line: Line, ego: EgoState) -> carla.Waypoint | None:
    """Return the first waypoint ahead of the ego at which the map's nearest lane is the waypoint's own lane."""
    for item in line[_nearest_index(line, ego) + 1 :]:
        nearest = carla_map.get_waypoint(item.transform.location)
        if nearest is not None and (nearest.road_id, nearest.lane_id) == (item.road_id, item.lane_id):
            return item
    return None


def _nearest_index(line: Line, ego: EgoState) -> int:
    places = np.array([to_local(item.transform.location) for item in line])
    return nearest_index(places, ego.x_m, ego.y_m)


def _can_join(line: Line, ego: EgoState, stopped: Sequence[Any], surface: Any) -> bool:
    """Return True if the ego can join a connection with one or two bends."""
    here = _nearest_index(line, ego)
    for ahead in (here + int(join) for join in JOIN_DISTANCES_M):
        if ahead >= len(line):
            return False
        transform = line[ahead].transform
        end = (*to_local(transform.location), yaw_to_local(transform.rotation.yaw))
        x, y, yaw = transition_curve((ego.x_m, ego.y_m, ego.yaw_rad), end)
        if max_curvature(x, y) > 1.0 / ego.limits.min_turn_radius_m:
            continue
        bodies = [_footprint(a, b, c, ego.length_m, ego.width_m) for a, b, c in zip(x, y, yaw, strict=True)]
        swept = shapely.union_all(bodies)
        if surface.covers(swept) and not any(swept.distance(obj) < CLEARANCE_M for obj in stopped):
            return True
    return False


def _surface(junction: Any, lines: Sequence[Line]) -> Any:
    """Return the area of a junction: its lanes, the surface between them, and the lanes into and out of it."""
    paths = [*lines, *(_line_through(begin) for begin, _ in junction.get_waypoints(carla.LaneType.Driving))]
    strips = [
        shapely.LineString([to_local(item.transform.location) for item in path]).buffer(
            max(item.lane_width for item in path) / 2, cap_style="flat"
        )
        for path in paths
        if len(path) > 1
    ]
    return shapely.union_all(strips).buffer(HALF_GAP_M).buffer(OVERHANG_M - HALF_GAP_M)


def _line_through(begin: Any) -> Line:
    """Return a lane through a junction, from `ENTRY_M` before it to the first waypoint after it."""
    path = [*begin.previous(ENTRY_M)[:1], begin]
    while path[-1].is_junction:
        after = path[-1].next(1.0)
        if not after:
            break
        path.append(after[0])
    return path


def transition_curve(start: tuple[float, float, float], end: tuple[float, float, float]) -> tuple[Any, Any, Any]:
    """Return x, y and heading along the cubic Hermite curve from one (x, y, heading) to another (m, rad)."""
    u = np.linspace(0.0, 1.0, SAMPLES)
    reach = math.hypot(end[0] - start[0], end[1] - start[1])
    blend = (2 * u**3 - 3 * u**2 + 1, u**3 - 2 * u**2 + u, 3 * u**2 - 2 * u**3, u**3 - u**2)
    tangents = [(reach * math.cos(item[2]), reach * math.sin(item[2])) for item in (start, end)]
    x, y = (
        blend[0] * start[k] + blend[1] * tangents[0][k] + blend[2] * end[k] + blend[3] * tangents[1][k] for k in (0, 1)
    )
    return x, y, np.arctan2(np.gradient(y), np.gradient(x))


def max_curvature(x: Any, y: Any) -> float:
    """Return the maximum curvature along a line (1/m)."""
    dx, dy = np.gradient(x), np.gradient(y)
    bend = np.abs(dx * np.gradient(dy) - dy * np.gradient(dx)) / np.maximum(np.hypot(dx, dy), 1e-6) ** 3
    return float(bend.max())


def _footprint(x: float, y: float, yaw: float, length: float, width: float) -> Any:
    box = shapely.box(-length / 2, -width / 2, length / 2, width / 2)
    corners = shapely.get_coordinates(box)[:4]
    c, n = math.cos(yaw), math.sin(yaw)
    return shapely.Polygon(corners @ np.array([[c, n], [-n, c]]) + (x, y))


def _is_stopped(obj: TrackedObject) -> bool:
    return math.hypot(obj.vx_mps, obj.vy_mps) < STOPPED_MPS


def road_ahead(road: RouteRoad, after: int) -> Any:
    """Return points (x, y) of the present route from `ROAD_FROM_M` to `ROAD_TO_M` beyond a station, in the local frame.

    The station is, for example, the first one after the junction.
    """
    part = road.stations[after + int(ROAD_FROM_M / SPACING_M) : after + int(ROAD_TO_M / SPACING_M)]
    return shapely.MultiPoint([(item.x, item.y) for item in part])


def route_length_m(carla_map: carla.Map, start: Any, destination: Any, avoided_road: Any) -> float | None:
    """Return the route length from a waypoint to a `carla.Location` (m); None if no route avoids `avoided_road`."""
    try:
        route = trace_route(carla_map, start.transform.location, destination)
    except RouteError:
        return None
    line = shapely.LineString([to_local(item.waypoint.transform.location) for item in route])
    returns = not avoided_road.is_empty and line.distance(avoided_road) < SAME_ROAD_M
    return None if returns else float(line.length)


def _turn(line: Line) -> str:
    yaws = [item.transform.rotation.yaw for item in line]
    # CARLA's yaw grows clockwise. Below 33 degrees the connection counts as straight (ours).
    angle = math.remainder(yaws[-1] - yaws[0], 360.0)
    return "straight" if abs(angle) < 33.0 else ("right" if angle > 0.0 else "left")
