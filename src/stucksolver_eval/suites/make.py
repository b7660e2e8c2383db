"""Places the routes of the suites that ship on the maps that ship.

    python -m stucksolver_eval.suites.make           writes data/*.xml
    python -m stucksolver_eval.suites.make --check   fails when a committed file differs

`bench220`: five routes of each of the 44 public scenario types. `dev`: one route of every second type, with the
same ids. `immobilized`: five routes of each stuck situation (or control) of our own that is registered as a scenario.
The same maps give the same files.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import carla

from stucksolver_eval.routes import Pose, Position, Route, ScenarioSpec, write_routes
from stucksolver_eval.scenarios.registry import SCENARIOS, load_all
from stucksolver_eval.suites import DATA
from stucksolver_eval.suites.along import NEEDS as ALONG
from stucksolver_eval.suites.along import sites as sites_along
from stucksolver_eval.suites.movements import movements
from stucksolver_eval.suites.ramps import FINDERS, Finder
from stucksolver_eval.suites.site import Site
from stucksolver_eval.suites.situations import SITUATIONS
from stucksolver_eval.suites.through import NEEDS as THROUGH
from stucksolver_eval.suites.through import sites as sites_through
from stucksolver_eval.suites.values import draw
from stucksolver_eval.suites.walk import Town
from stucksolver_eval.suites.weathers import weather

TOWNS = ("grid_town", "interurban", "motorway")
MAPS = Path(__file__).resolve().parents[2] / "carlette" / "maps"
TYPES = tuple(sorted((*ALONG, *THROUGH, *FINDERS)))
ONLY_IN = {
    "ClosedRoad": "grid_town",
    "EnterActorFlow": "interurban",
    "HazardAtSideLane": "grid_town",
    "InterurbanActorFlow": "interurban",
    "InterurbanAdvancedActorFlow": "interurban",
}
"""Blocks one can drive round, flows too fast for a town's streets, and no bicycles on a motorway."""
ROUTES_EACH = 5
_FIRST_ID, _FIRST_OF_OURS = 1000, 3000
_IDS_EACH = 10
_DECIMALS = 2


def main(arguments: list[str] | None = None) -> int:
    """Runs the script; 1 when `--check` finds a difference."""
    parser = argparse.ArgumentParser(prog="python -m stucksolver_eval.suites.make", description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare, do not write")
    check = parser.parse_args(arguments).check
    towns = load_towns()
    routes = bench220(towns)
    suites = {"bench220": routes, "dev": dev(routes), "immobilized": immobilized(towns)}
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) if check else DATA
        for name, placed in suites.items():
            if placed:
                write_routes(folder / f"{name}.xml", placed)
        differing = [path.name for path in folder.glob("*.xml") if path.read_bytes() != _bytes(DATA / path.name)]
    for name in differing:
        print(f"{name} differs: run `python -m stucksolver_eval.suites.make`", file=sys.stderr)
    return 1 if differing else 0


def load_towns(folder: Path = MAPS) -> list[Town]:
    """The maps that the suites use."""
    return [Town(name, carla.Map(name, (folder / f"{name}.xodr").read_text("utf-8"))) for name in TOWNS]


def bench220(towns: Sequence[Town]) -> list[Route]:
    """Five routes of each type. Raises ValueError where the maps have too few sites for one."""
    return _routes({kind: _public(kind) for kind in TYPES}, towns, _FIRST_ID)


def immobilized(towns: Sequence[Town]) -> list[Route]:
    """Five routes of each of our own situations that there is a scenario for. Raises ValueError as above."""
    load_all()
    routes = _routes(SITUATIONS, towns, _FIRST_OF_OURS)
    return [route for route in routes if route.scenarios[0].type in SCENARIOS]


def dev(routes: Sequence[Route]) -> list[Route]:
    """One route of every second type, not always the first."""
    return [routes[index * ROUTES_EACH + (index // 2) % ROUTES_EACH] for index in range(0, len(TYPES), 2)]


def _public(kind: str) -> Finder:
    """What finds the sites of one of the 44 types."""
    if kind in ALONG:
        return lambda town, ways: sites_along(ALONG[kind], town)
    if kind in THROUGH:
        return lambda town, ways: sites_through(THROUGH[kind], ways)
    return FINDERS[kind]


def _routes(finders: Mapping[str, Finder], towns: Sequence[Town], first_id: int) -> list[Route]:
    ways = {town.name: movements(town) for town in towns}
    routes = []
    for index, (kind, find) in enumerate(finders.items()):
        fitting = [town for town in towns if ONLY_IN.get(kind, town.name) == town.name]
        sites = [site for town in fitting for site in find(town, ways[town.name])]
        for number, site in enumerate(_spread(kind, sites)):
            routes.append(_route(kind, site, index * ROUTES_EACH + number, first_id + index * _IDS_EACH + number))
    return routes


def _spread(kind: str, sites: list[Site]) -> list[Site]:
    """Five sites: from as many lanes, at as many junctions, and on as many maps as there are."""
    chance = random.Random(kind)
    chance.shuffle(sites)
    chosen: list[Site] = []
    while len(chosen) < ROUTES_EACH:
        if not sites:
            raise ValueError(f"{kind}: {len(chosen)} sites, {ROUTES_EACH} are needed; add roads that fit to a map")
        chosen.append(min(sites, key=lambda one: _likeness(one, chosen)))
        sites = [one for one in sites if (one.town, one.place) != (chosen[-1].town, chosen[-1].place)]
    return chosen


def _likeness(site: Site, chosen: list[Site]) -> tuple[int, int, int]:
    """How many of those chosen start on the same lane, lie at the same junction or road, or on the same map."""
    here = [one for one in chosen if one.town is site.town]
    lane = (site.trigger.road_id, site.trigger.lane_id)
    same_lane = sum((one.trigger.road_id, one.trigger.lane_id) == lane for one in here)
    return same_lane, sum(one.group == site.group for one in here), len(here)


def _route(kind: str, site: Site, number: int, route_id: int) -> Route:
    parameters = draw(kind, random.Random(f"{kind} {number}"), site.free_m)
    parameters.update({name: _xyz(where) for name, where in site.positions.items()})
    parameters.update(site.fixed)
    yaw_deg = math.remainder(site.trigger.transform.rotation.yaw, 360.0)
    trigger = Pose(_position(site.trigger), round(yaw_deg, _DECIMALS) + 0.0)
    spec = ScenarioSpec(f"{kind}_{number % ROUTES_EACH + 1}", kind, trigger, parameters)
    marks = tuple(_position(one) for one in site.marks)
    return Route(str(route_id), site.town.name, marks, weather(number), (spec,))


def _bytes(path: Path) -> bytes:
    return path.read_bytes() if path.exists() else b""


def _position(waypoint: Any) -> Position:
    place = waypoint.transform.location
    return Position(*(round(value, _DECIMALS) + 0.0 for value in (place.x, place.y, place.z)))


def _xyz(waypoint: Any) -> dict[str, str]:
    place = _position(waypoint)
    return {"x": str(place.x_m), "y": str(place.y_m), "z": str(place.z_m)}


if __name__ == "__main__":
    sys.exit(main())
