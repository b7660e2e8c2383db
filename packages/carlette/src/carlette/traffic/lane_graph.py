"""The driving lanes of a map as arrays: points about every meter, grouped into lanes, linked into a graph."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from carlette.geometry import Floats
from carlette.opendrive.road_network import RoadNetwork
from carlette.opendrive.traffic_side import runs_back
from carlette.traffic.lane_point_grid import OTHER_LEVEL_M, LanePointGrid, make_grid
from carlette.world.fork import shared

SPACING_M = 1.0
"""Distance between two lane points (m)."""
LEAST_SPACING_M = 0.2
"""Least distance between two lane points (m). Ours."""
NEAR_M = 3.0
"""Distance to the nearest lane beyond which a car is on none (m). Ours."""
SIDE_MPS2 = 2.2
"""Lateral acceleration in a bend (m/s²). Ours."""
CRAWL_MPS = 2.5
"""Least speed in a bend (m/s). Ours."""
CROSSING_M = 2.8
"""Distance between the centers of two lanes in a junction below which only one of them may be used (m). Ours."""
BEND_POINTS = 3
"""Number of points before and after a point over which the curvature of a bend is measured. Ours."""

Ints = NDArray[np.int64]
Key = tuple[int, int, int]


@shared
@dataclass(frozen=True, eq=False)
class TrafficLaneGraph:
    """All lanes of a map. Lane `i` owns the points `first[i]` to `first[i + 1]`. It never changes."""

    place: Floats
    """(points, 3), world frame (m)."""
    ahead: Floats
    """(points, 2): unit vectors along the lane."""
    along: Floats
    """Distance from the start of the lane (m)."""
    speed: Floats
    """Highest speed that a bend allows (m/s)."""
    lane: Ints
    """The lane of each point."""
    first: Ints
    inside: NDArray[np.bool_]
    """(lanes,): True if the lane runs through a junction."""
    after: list[list[int]]
    """Successors of each lane."""
    crossing: list[frozenset[int]]
    """Lanes of the same junction that must be empty before this one may be used."""
    grid: LanePointGrid
    """The points by their positions."""

    def nearest(self, place: Floats, yaw_rad: float) -> int:
        """Return the lane point nearest to a vehicle with about the lane's heading; -1 if none is near."""
        _, points = self.grid.candidates(place[None], NEAR_M)
        gap = self.place[points] - place
        far = np.hypot(gap[:, 0], gap[:, 1])
        heading = self.ahead[points] @ (math.cos(yaw_rad), math.sin(yaw_rad))
        fits = (heading > 0.5) & (np.abs(gap[:, 2]) < OTHER_LEVEL_M) & (far < NEAR_M)
        return int(points[np.where(fits, far, np.inf).argmin()]) if fits.any() else -1


_graphs: WeakKeyDictionary[RoadNetwork, TrafficLaneGraph] = WeakKeyDictionary()


def lane_graph(roads: RoadNetwork) -> TrafficLaneGraph:
    """Return the graph of a map. It is built once."""
    if roads not in _graphs:
        _graphs[roads] = _build(roads)
    return _graphs[roads]


def _build(roads: RoadNetwork) -> TrafficLaneGraph:
    links = _links(roads)
    lanes = _lanes(roads)
    keys = sorted(lanes)
    number = {key: index for index, key in enumerate(keys)}
    chains = [lanes[key] for key in keys]
    first = np.cumsum([0, *map(len, chains)])
    points = [point for chain in chains for point in chain]
    transforms = [point.transform for point in points]
    place = np.array([(transform.location.x, transform.location.y, transform.location.z) for transform in transforms])
    yaw = np.radians([transform.rotation.yaw for transform in transforms])
    lane = np.repeat(np.arange(len(chains)), np.diff(first))
    inside = np.array([chain[0].is_junction for chain in chains])
    after = [sorted({number[link] for link in links.get(key, ()) if link in number}) for key in keys]
    steps = np.hypot(*np.diff(place[:, :2], axis=0, prepend=place[:1, :2]).T)
    steps[first[:-1]] = 0.0
    run = np.cumsum(steps)
    return TrafficLaneGraph(
        place=place,
        ahead=np.stack([np.cos(yaw), np.sin(yaw)], axis=1),
        along=run - run[first[:-1]][lane],
        speed=_bend_speeds(place, yaw, lane),
        lane=lane,
        first=first,
        inside=inside,
        after=after,
        crossing=_crossings(chains, place, first, after),
        grid=make_grid(place),
    )


def _links(roads: RoadNetwork) -> dict[Key, set[Key]]:
    """Return the successors of each lane. In the library, a lane that ends is its own successor."""
    links: dict[Key, set[Key]] = {}
    for begin, end in roads.map.get_topology():
        if _key(begin) != _key(end):
            links.setdefault(_key(begin), set()).add(_key(end))
    return links


def _lanes(roads: RoadNetwork) -> dict[Key, list[Any]]:
    """Return the waypoints of each driving lane in the direction of travel."""
    lanes: dict[Key, list[Any]] = {}
    for begin, _ in roads.map.get_topology():
        lanes.setdefault(_key(begin), [begin])
    for waypoint in roads.map.generate_waypoints(SPACING_M):
        lanes.setdefault(_key(waypoint), []).append(waypoint)
    return {
        key: _spaced(sorted(lane, key=lambda item: item.s, reverse=runs_back(lane[0]))) for key, lane in lanes.items()
    }


def _spaced(lane: list[Any]) -> list[Any]:
    """Return the lane without points that almost coincide with the one before."""
    spaced = [lane[0]]
    spaced += [item for before, item in pairwise(lane) if abs(item.s - before.s) > LEAST_SPACING_M]
    return spaced


def _key(waypoint: Any) -> Key:
    return waypoint.road_id, waypoint.section_id, waypoint.lane_id


def _bend_speeds(place: Floats, yaw: Floats, lane: Ints) -> Floats:
    """Return speeds (m/s) that keep the lateral acceleration within `SIDE_MPS2`, from the turn over a few meters."""
    count = len(yaw)
    before = np.maximum(np.arange(count) - BEND_POINTS, 0)
    behind = np.minimum(np.arange(count) + BEND_POINTS, count - 1)
    before = np.where(lane[before] == lane, before, np.arange(count))
    behind = np.where(lane[behind] == lane, behind, np.arange(count))
    turn = np.abs((yaw[behind] - yaw[before] + np.pi) % (2 * np.pi) - np.pi)
    length = np.hypot(*(place[behind, :2] - place[before, :2]).T)
    bend = turn / np.maximum(length, SPACING_M)
    speeds: Floats = np.maximum(np.sqrt(SIDE_MPS2 / np.maximum(bend, 1e-4)), CRAWL_MPS)
    return speeds


def _crossings(chains: list[list[Any]], place: Floats, first: Ints, after: list[list[int]]) -> list[frozenset[int]]:
    """Return, for each lane in a junction, the others with near centers, except those with the same start."""
    junctions: dict[int, list[int]] = {}
    for number, chain in enumerate(chains):
        if chain[0].is_junction:
            junctions.setdefault(chain[0].junction_id, []).append(number)
    before: dict[int, set[int]] = {}
    for number, following in enumerate(after):
        for item in following:
            before.setdefault(item, set()).add(number)
    found: list[set[int]] = [set() for _ in chains]
    for members in junctions.values():
        for member in members:
            for other in members:
                shares_begin = bool(before.get(member, set()) & before.get(other, set()))
                if member < other and not shares_begin:
                    gap = place[first[member] : first[member + 1], None] - place[None, first[other] : first[other + 1]]
                    if ((gap * gap).sum(axis=2) < CROSSING_M**2).any() and not _linked(member, other, after):
                        found[member].add(other)
                        found[other].add(member)
    return [frozenset(item) for item in found]


def _linked(first: int, second: int, after: list[list[int]]) -> bool:
    return second in after[first] or first in after[second]
