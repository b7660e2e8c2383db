"""Plans shortest legal routes on a `carla.Map`, as points about one meter apart with a command at each."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from stucksolver_carla.drivers.behavior.graph_search import Edge, NoRouteError, shortest_path
from stucksolver_carla.drivers.behavior.lane_graph import LaneGraph, lane_graph, lane_key
from stucksolver_carla.drivers.driver_interface import RoutePoint

if TYPE_CHECKING:
    import carla

TURN_THRESHOLD_RAD = math.radians(33.0)
"""Heading change through a junction above which it is a turn (`GlobalRoutePlanner`, CARLA agents, MIT)."""

LANE_FOLLOW = "lane_follow"
"""The command outside junctions and lane changes."""
_SAME_PLACE_M = 0.3
"""Distance below which two successive points have the same position (m). Ours."""


class RouteError(Exception):
    """No route leads from start to destination. The message names both and a remedy."""

    def __init__(self, start: Any, end: Any, reason: str, remedy: str) -> None:
        self.start, self.end = start, end
        super().__init__(f"no route from {_text_of(start)} to {_text_of(end)}: {reason}; {remedy}")


def trace_route(carla_map: carla.Map, start: Any, end: Any) -> list[RoutePoint]:
    """Return the shortest route between two `carla.Location`s, each moved to the nearest driving lane.

    Lane changes cost 15 m extra, so a route has no needless ones.

    Raises:
        RouteError: No route exists.
    """
    graph = lane_graph(carla_map)
    first = _locate(carla_map, graph, start, (start, end))
    last = _locate(carla_map, graph, end, (start, end))
    try:
        indices, commands = _search(graph, first, last)
    except NoRouteError as error:
        remedy = "choose a destination that can be driven to, or allow another start lane"
        raise RouteError(start, end, "the lanes do not connect", remedy) from error
    points = [graph.samples[i] for i in indices]
    route = [RoutePoint(w, c) for w, c in zip(points, _with_turns(points, commands), strict=True)]
    # The end of a lane and the start of the next one have the same position.
    kept_indices = [a for a, b in itertools.pairwise(indices) if graph.distance_m(a, b) >= _SAME_PLACE_M]
    selected = {*kept_indices, indices[-1]}
    return [point for i, point in zip(indices, route, strict=True) if i in selected]


def _locate(carla_map: carla.Map, graph: LaneGraph, location: carla.Location, ends: tuple[Any, Any]) -> int:
    waypoint = carla_map.get_waypoint(location)
    index = None if waypoint is None else graph.locate(waypoint)
    if index is None:
        reason = f"no driving lane found near {_text_of(location)}"
        raise RouteError(*ends, reason, "give a location on a lane that belongs to the map's topology")
    return index


def _search(graph: LaneGraph, first: int, last: int) -> tuple[list[int], list[str]]:
    """Return the sample indices from `first` to `last`, and the command at each, without turns."""
    lane_first, lane_last = graph.lane_span(first)
    if first <= last <= lane_last and last >= lane_first:
        return list(range(first, last + 1)), [LANE_FOLLOW] * (last - first + 1)
    source, target = graph.node_at_or_after(first), graph.node_at_or_before(last)
    nodes = shortest_path(graph.edges, source, target, graph.distance_m)
    indices, commands = list(range(first, source + 1)), [LANE_FOLLOW] * (source + 1 - first)
    for a, b in itertools.pairwise(nodes):
        stretch, command = _stretch(graph, a, b, graph.edges[a][b])
        indices.extend(stretch)
        commands.extend([command] * len(stretch))
    rest = range(target + 1, last + 1)
    return indices + list(rest), commands + [LANE_FOLLOW] * len(rest)


def _stretch(graph: LaneGraph, a: int, b: int, edge: Edge) -> tuple[range, str]:
    """Return the samples after node `a` up to node `b`, and their command."""
    if edge.change:
        return range(min(edge.abreast + 1, b), b + 1), f"change_{edge.change}"
    same_lane = lane_key(graph.samples[a]) == lane_key(graph.samples[b]) and b > a
    return range(a + 1 if same_lane else b, b + 1), LANE_FOLLOW


def _with_turns(points: Sequence[Any], commands: list[str]) -> list[str]:
    """Return the commands with the turns in place of `lane_follow` inside junctions."""
    with_turns = list(commands)
    inside = [bool(w.is_junction) for w in points]
    i = 0
    while i < len(points):
        j = i
        while j < len(points) and inside[j]:
            j += 1
        if j > i:
            turn = _turn(points[max(i - 1, 0)], points[min(j, len(points) - 1)])
            with_turns[i:j] = [turn if c == LANE_FOLLOW else c for c in with_turns[i:j]]
        i = max(j, i + 1)
    return with_turns


def _turn(before: Any, after: Any) -> str:
    delta = math.radians(after.transform.rotation.yaw - before.transform.rotation.yaw)
    delta = math.remainder(delta, math.tau)
    if abs(delta) < TURN_THRESHOLD_RAD:
        return "straight"
    # CARLA's yaw grows clockwise.
    return "right" if delta > 0.0 else "left"


def _text_of(location: carla.Location) -> str:
    return f"({location.x:.1f}, {location.y:.1f})"
