"""Searches the shortest path through a directed graph of numbered nodes."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Edge:
    """An edge from one node to the next. `change` is the side of a lane change, or empty.

    `abreast` is the sample next to the start in the new lane. It is used for lane changes only.
    """

    cost_m: float
    change: str = ""
    abreast: int = 0


Edges = dict[int, dict[int, Edge]]
"""The edges from each node, by their end nodes."""


class NoRouteError(Exception):
    """The target cannot be reached."""


def shortest_path(edges: Edges, source: int, target: int, min_cost_m: Callable[[int, int], float]) -> list[int]:
    """Return the cheapest path, found with A*. Of equal paths the one found first wins.

    Args:
        edges: The graph.
        source: The start node.
        target: The end node.
        min_cost_m: Returns a lower bound of the cost between two nodes. Along an edge, it must decrease by no more than
            the edge's cost.

    Returns:
        The nodes of the path with both ends.

    Raises:
        NoRouteError: No path exists.
    """
    order = itertools.count()
    queue: list[tuple[float, int, int, float, int | None]] = [(0.0, next(order), source, 0.0, None)]
    best_m: dict[int, float] = {source: 0.0}
    predecessors: dict[int, int | None] = {}
    while queue:
        _, _, node, cost_m, previous_node = heapq.heappop(queue)
        # Rounding may make another path to a node a little cheaper. The node is then expanded again.
        if node in predecessors and best_m[node] < cost_m:
            continue
        predecessors[node] = previous_node
        if node == target:
            return _path_to(node, predecessors)
        for neighbor, edge in edges.get(node, {}).items():
            cost_there_m = cost_m + edge.cost_m
            if neighbor in best_m and best_m[neighbor] <= cost_there_m:
                continue
            best_m[neighbor] = cost_there_m
            estimate_m = cost_there_m + min_cost_m(neighbor, target)
            heapq.heappush(queue, (estimate_m, next(order), neighbor, cost_there_m, node))
    raise NoRouteError


def _path_to(node: int, predecessors: dict[int, int | None]) -> list[int]:
    path = [node]
    while (predecessor := predecessors[path[-1]]) is not None:
        path.append(predecessor)
    return path[::-1]
