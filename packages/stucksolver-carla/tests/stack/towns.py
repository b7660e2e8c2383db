"""Towns as `carla.Map` without a server, and routes in them."""

from __future__ import annotations

import os
import random
from functools import lru_cache
from pathlib import Path
from typing import Any

import carla
import pytest

from carlette.maps import DEMO_TOWN
from stucksolver_carla.drivers.behavior import RouteError, RoutePoint
from stucksolver_carla.drivers.behavior.routing import trace_route
from stucksolver_carla.stack.route_road import RouteRoad

TOWNS = ("demo_town", "Town01", "Town04", "Town10HD")
FOLDERS = [Path(folder) for folder in os.environ.get("STUCKSOLVER_MAPS", "").split(os.pathsep) if folder]
Place = tuple[int, int, float]
"""Road, lane and arc length along the road, as `carla.Map.get_waypoint_xodr` takes them."""


def town(name: str) -> Any:
    """The map of a town, or a skip that says what is missing."""
    places = [DEMO_TOWN] if name == "demo_town" else [folder / f"{name}.xodr" for folder in FOLDERS]
    for path in places:
        if path.is_file():
            return _load(name, path)
    pytest.skip(f"{name}.xodr is in none of the folders of STUCKSOLVER_MAPS")


@lru_cache(maxsize=4)
def _load(name: str, path: Path) -> Any:
    return carla.Map(name, path.read_text(encoding="utf-8"))


def route(town_map: Any, start: Place, end: Place) -> list[RoutePoint]:
    """The way between two places, as the driver plans it."""
    ends = [town_map.get_waypoint_xodr(*place).transform.location for place in (start, end)]
    return list(trace_route(town_map, *ends))


@lru_cache(maxsize=8)
def demo_road(start: Place, end: Place) -> RouteRoad:
    """A road of the demo town."""
    return RouteRoad(town("demo_town"), route(town("demo_town"), start, end))


@lru_cache(maxsize=4)
def some_routes(name: str, count: int = 5) -> tuple[list[RoutePoint], ...]:
    """A few routes of about 250 m through a town, each begun on another lane; the same on every call."""
    chance, town_map = random.Random(4), town(name)
    starts = [w for w, _ in town_map.get_topology() if not w.is_junction]
    chance.shuffle(starts)
    found: list[list[RoutePoint]] = []
    for start in starts:
        end = _onward(start, 250, chance)
        if len(found) == count:
            break
        try:
            way = list(trace_route(town_map, start.transform.location, end.transform.location))
        except RouteError:
            continue
        if 150 < len(way) < 500:
            found.append(way)
    assert len(found) == count
    return tuple(found)


@lru_cache(maxsize=4)
def some_roads(name: str) -> tuple[RouteRoad, ...]:
    """The roads along these routes."""
    return tuple(RouteRoad(town(name), way) for way in some_routes(name))


def _onward(waypoint: Any, length_m: int, chance: random.Random) -> Any:
    for _ in range(length_m):
        waypoint = chance.choice(waypoint.next(1.0) or [waypoint])
    return waypoint
