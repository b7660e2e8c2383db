"""Represents the road network of a `carla.Map` as a directed graph of lane samples about a meter apart.

This follows the published behavior of `GlobalRoutePlanner` (CARLA PythonAPI agents package, MIT): lanes come from
`Map.get_topology`, and a lane change is an edge wherever the lane markings permit one. Unlike there, every second
sample is a node. So a change may happen anywhere along a lane, and always takes some length.
"""

from __future__ import annotations

import itertools
import math
from collections import OrderedDict
from collections.abc import Callable
from functools import cached_property
from typing import Any

import carla

from stucksolver_carla.drivers.behavior.graph_search import Edge, Edges

SAMPLING_M = 1.0
"""Distance between two samples of a lane (m)."""
NODE_STRIDE = 2
"""Number of samples per node. Ours."""
LANE_CHANGE_LENGTH_M = 10
"""Length of a lane change in the graph (samples, m). Ours."""
LANE_CHANGE_COST_M = 15.0
"""Additional cost of a lane change (m). Ours."""
LATE_CHANGE_COST = 0.02
"""Additional cost of a lane change per meter of lane before it: of two equal routes, the one with the earlier change
wins. Ours."""
_MIN_CHANGE_LENGTH_M = 3
"""Minimum length of a lane from or into which a lane change leads (samples, m). Ours."""
_CACHED_MAPS = 4
"""Maximum number of maps in the cache. Ours."""
_SEED_SPACING_M = 50.0
"""Distance between the waypoints from which lanes missing in the topology are found (m). Ours."""

LaneKey = tuple[int, int, int]


def lane_key(waypoint: carla.Waypoint) -> LaneKey:
    """Return road, section and lane id of a waypoint: the key of its lane."""
    return (waypoint.road_id, waypoint.section_id, waypoint.lane_id)


class LaneGraph:
    """Lane samples of one map, and the edges between them, in CARLA's world frame (m)."""

    def __init__(self, carla_map: carla.Map) -> None:
        self.samples: list[Any] = []
        self.xy: list[tuple[float, float]] = []
        self.edges: Edges = {}
        self._span: dict[LaneKey, tuple[int, int]] = {}
        self._successors: dict[LaneKey, set[LaneKey]] = {}
        self._add_topology(carla_map.get_topology(), carla_map.generate_waypoints(_SEED_SPACING_M))
        for key in self._span:
            self._link_forward(key)
        # The forward links come first, so that all lanes have their ends before changes into short lanes are excluded.
        for key in list(self._span):
            self._link_changes(key)

    def locate(self, waypoint: carla.Waypoint) -> int | None:
        """Return the index of the sample nearest to `waypoint` on its lane; None if that lane is not in the graph."""
        span = self._span.get(lane_key(waypoint))
        if span is None:
            return None
        first, last = span
        offset = round(abs(float(waypoint.s) - float(self.samples[first].s)) / SAMPLING_M)
        return min(first + offset, last)

    def lane_span(self, index: int) -> tuple[int, int]:
        """Return the first and last sample index of the lane of sample `index`."""
        return self._span[lane_key(self.samples[index])]

    def node_at_or_after(self, index: int) -> int:
        """Return the nearest graph node ahead of (or at) a sample, on the same lane."""
        first, last = self.lane_span(index)
        return min(first + -(-(index - first) // NODE_STRIDE) * NODE_STRIDE, last)

    def node_at_or_before(self, index: int) -> int:
        """Return the nearest graph node behind (or at) a sample, on the same lane."""
        first, last = self.lane_span(index)
        return index if index == last else first + (index - first) // NODE_STRIDE * NODE_STRIDE

    def lanes_of_junction(self, junction_id: int) -> list[LaneKey]:
        """Return the lanes through a junction."""
        return self._junctions.get(junction_id, [])

    def span_of(self, key: LaneKey) -> tuple[int, int] | None:
        """Return the first and last sample index of a lane; None if it is not in the graph."""
        return self._span.get(key)

    def before(self, key: LaneKey) -> set[LaneKey]:
        """Return the lanes that lead to a lane."""
        return self._predecessors.get(key, set())

    def after(self, key: LaneKey) -> set[LaneKey]:
        """Return the lanes to which a lane leads."""
        return {successor for successor in self._successors.get(key, set()) if successor in self._span}

    @cached_property
    def _predecessors(self) -> dict[LaneKey, set[LaneKey]]:
        predecessors: dict[LaneKey, set[LaneKey]] = {}
        for key in self._span:
            for successor in self.after(key):
                predecessors.setdefault(successor, set()).add(key)
        return predecessors

    @cached_property
    def _junctions(self) -> dict[int, list[LaneKey]]:
        lanes: dict[int, list[LaneKey]] = {}
        for key, (first, _) in self._span.items():
            if self.samples[first].is_junction:
                lanes.setdefault(self.samples[first].junction_id, []).append(key)
        return lanes

    def distance_m(self, a: int, b: int) -> float:
        """Return the straight distance between two samples (m): the heuristic of the search."""
        return math.dist(self.xy[a], self.xy[b])

    def _add_topology(self, topology: list[tuple[Any, Any]], seeds: list[Any]) -> None:
        entries = {lane_key(entry) for entry, _ in topology}
        for entry, leaving in topology:
            self._add_lane(entry)
            if lane_key(leaving) != lane_key(entry):
                self._successors[lane_key(entry)].add(lane_key(leaving))
        # The topology lists lanes at road ends only, and not all lanes of a dead end. Later sections of a road appear
        # only as the exit of another one, or not at all.
        pending = [leaving for _, leaving in topology if lane_key(leaving) not in entries] + seeds
        while pending:
            pending.extend(self._add_inner_lane(pending.pop()))

    def _add_inner_lane(self, entry: carla.Waypoint) -> list[carla.Waypoint]:
        """Add a lane that is not a road entry, and return the entries of later lanes that are not in the graph yet."""
        key = lane_key(entry)
        if key in self._span:
            return []
        self._add_lane(entry)
        last = self.samples[self._span[key][1]]
        following = [w for w in last.next(1.2 * SAMPLING_M) if lane_key(w) != key]
        self._successors[key].update(lane_key(w) for w in following)
        return [w for w in following if lane_key(w) not in self._span]

    def _add_lane(self, waypoint_inside: carla.Waypoint) -> None:
        key = lane_key(waypoint_inside)
        if key in self._span:
            return
        entry = [waypoint_inside, *_along_lane(waypoint_inside, lambda waypoint: waypoint.previous(SAMPLING_M))][-1]
        lane = [entry, *_along_lane(entry, lambda waypoint: waypoint.next(SAMPLING_M))]
        first = len(self.samples)
        for waypoint in lane:
            location = waypoint.transform.location
            self.samples.append(waypoint)
            self.xy.append((location.x, location.y))
        self._span[key] = (first, len(self.samples) - 1)
        self._successors[key] = set()

    def _nodes(self, key: LaneKey) -> list[int]:
        first, last = self._span[key]
        nodes = list(range(first, last + 1, NODE_STRIDE))
        return nodes if nodes[-1] == last else [*nodes, last]

    def _link_forward(self, key: LaneKey) -> None:
        nodes = self._nodes(key)
        for a, b in itertools.pairwise(nodes):
            self._link(a, b, Edge(self.distance_m(a, b)))
        for successor in self._successors[key]:
            if successor in self._span:
                entry = self._span[successor][0]
                self._link(nodes[-1], entry, Edge(self.distance_m(nodes[-1], entry)))

    def _link_changes(self, key: LaneKey) -> None:
        first, last = self._span[key]
        if self.samples[first].is_junction or last - first < _MIN_CHANGE_LENGTH_M:
            return
        for node in self._nodes(key):
            allowed = self.samples[node].lane_change
            if allowed in (carla.LaneChange.Right, carla.LaneChange.Both):
                self._link_change(node, self.samples[node].get_right_lane(), "right")
            if allowed in (carla.LaneChange.Left, carla.LaneChange.Both):
                self._link_change(node, self.samples[node].get_left_lane(), "left")

    def _link_change(self, node: int, neighbor: Any, side: str) -> None:
        if neighbor is None or neighbor.lane_type != carla.LaneType.Driving:
            return
        if neighbor.lane_id * self.samples[node].lane_id < 0:
            return
        abreast = self.locate(neighbor)
        if abreast is None:
            return
        first, last = self.lane_span(abreast)
        if last - abreast < _MIN_CHANGE_LENGTH_M:
            return
        target = self.node_at_or_after(min(abreast + LANE_CHANGE_LENGTH_M, last))
        cost = self.distance_m(node, target) + LANE_CHANGE_COST_M + LATE_CHANGE_COST * (abreast - first)
        self._link(node, target, Edge(cost, side, abreast))

    def _link(self, start: int, end: int, edge: Edge) -> None:
        self.edges.setdefault(start, {})[end] = edge


def _along_lane(
    waypoint: carla.Waypoint, step: Callable[[carla.Waypoint], list[carla.Waypoint]]
) -> list[carla.Waypoint]:
    """Return the waypoints of repeated calls of `step` on the same lane.

    `Waypoint.next_until_lane_end` would be shorter, but it crashes if a road has no successor.
    """
    key, waypoints = lane_key(waypoint), list[Any]()
    while True:
        following = [w for w in step(waypoint) if lane_key(w) == key]
        # A road that is its own successor starts again from its beginning.
        if not following or abs(following[0].s - waypoint.s) > 2.0 * SAMPLING_M:
            return waypoints
        waypoint = following[0]
        waypoints.append(waypoint)


_cache: OrderedDict[tuple[str, int], LaneGraph] = OrderedDict()


def lane_graph(carla_map: carla.Map) -> LaneGraph:
    """Return the graph of a map, built once for its content, because `World.get_map` creates a new object each time."""
    key = (str(carla_map.name), hash(carla_map.to_opendrive()))
    if key not in _cache:
        _cache[key] = LaneGraph(carla_map)
        if len(_cache) > _CACHED_MAPS:
            _cache.popitem(last=False)
    _cache.move_to_end(key)
    return _cache[key]
