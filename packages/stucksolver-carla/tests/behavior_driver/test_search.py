"""The shortest way through a graph, against networkx."""

from __future__ import annotations

import math

import networkx as nx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver_carla.drivers.behavior.graph_search import Edge, Edges, NoRouteError, shortest_path

PLACES = st.lists(st.tuples(st.integers(0, 20), st.integers(0, 20)), min_size=2, max_size=12, unique=True)
LINKS = st.lists(st.tuples(st.integers(0, 11), st.integers(0, 11), st.sampled_from([1.0, 1.0, 1.5, 3.0])), max_size=60)


@given(PLACES, LINKS)
def test_the_way_is_the_one_that_networkx_finds(places, links):
    edges: Edges = {}
    graph = nx.DiGraph()
    graph.add_nodes_from(range(len(places)))
    for a, b, times in links:
        if max(a, b) < len(places):
            cost_m = times * math.dist(places[a], places[b])
            edges.setdefault(a, {})[b] = Edge(cost_m)
            graph.add_edge(a, b, length=cost_m)

    def at_least_m(a: int, b: int) -> float:
        return math.dist(places[a], places[b])

    source, target = 0, len(places) - 1
    try:
        expected = nx.astar_path(graph, source, target, heuristic=at_least_m, weight="length")
    except nx.NetworkXNoPath:
        with pytest.raises(NoRouteError):
            shortest_path(edges, source, target, at_least_m)
        return
    found = shortest_path(edges, source, target, at_least_m)
    assert (found[0], found[-1]) == (source, target)
    assert nx.path_weight(graph, found, "length") == pytest.approx(nx.path_weight(graph, expected, "length"))


def test_of_equal_ways_the_one_found_first_wins():
    edges = {0: {1: Edge(1.0), 2: Edge(1.0)}, 1: {3: Edge(1.0)}, 2: {3: Edge(1.0)}}
    assert shortest_path(edges, 0, 3, lambda a, b: 0.0) == [0, 1, 3]
