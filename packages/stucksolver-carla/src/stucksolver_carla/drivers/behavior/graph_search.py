"""A directed graph of numbered places, and the shortest way through it."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Edge:
    """A way from one place to the next. `change` is the side of a lane change, or empty.

    `abreast` is the sample beside the start in the lane that is changed to; it matters for lane changes only.
    """

    cost_m: float
    change: str = ""
    abreast: int = 0


Edges = dict[int, dict[int, Edge]]
"""Each place with the edges that start there, by the place where they end."""


class NoRouteError(Exception):
    """The target cannot be reached."""


def shortest_way(edges: Edges, source: int, target: int, at_least_m: Callable[[int, int], float]) -> list[int]:
    """Find the cheapest way with A*; of equal ways the one found first wins.

    Args:
        edges: The graph.
        source: The place to start from.
        target: The place to reach.
        at_least_m: Returns a lower bound of the cost between two places, which shrinks by no more than an edge costs.

    Returns:
        The places on the way, both ends included.

    Raises:
        NoWay: There is none.
    """
    order = itertools.count()
    queue: list[tuple[float, int, int, float, int | None]] = [(0.0, next(order), source, 0.0, None)]
    best_m: dict[int, float] = {source: 0.0}
    before: dict[int, int | None] = {}
    while queue:
        _, _, place, cost_m, came_from = heapq.heappop(queue)
        # Rounding may make a known way a little shorter; then its places are looked at again.
        if place in before and best_m[place] < cost_m:
            continue
        before[place] = came_from
        if place == target:
            return _way_to(place, before)
        for neighbour, edge in edges.get(place, {}).items():
            there_m = cost_m + edge.cost_m
            if neighbour in best_m and best_m[neighbour] <= there_m:
                continue
            best_m[neighbour] = there_m
            estimate_m = there_m + at_least_m(neighbour, target)
            heapq.heappush(queue, (estimate_m, next(order), neighbour, there_m, place))
    raise NoRouteError


def _way_to(place: int, before: dict[int, int | None]) -> list[int]:
    way = [place]
    while (previous := before[way[-1]]) is not None:
        way.append(previous)
    return way[::-1]
