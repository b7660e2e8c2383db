"""Places the routes of the shipped suites on the shipped maps.

```sh
python -m stucksolver_eval.suites.build           # writes data/*.xml
python -m stucksolver_eval.suites.build --check   # fails if a committed file differs
```

`bench220`: five routes of each of the 44 public scenario types. `dev`: one route of every second type, with the same
ids. `immobilized`: five routes of each additional immobilizing situation and control. `reported`: three routes of each
situation from public reports, in different towns where these have suitable places. Each type declares its suite
(`placed`). The same maps give the same files.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import carla

from carlette.maps import DEMO_TOWN
from stucksolver_eval.routes import Position, Route, RoutePose, ScenarioSpec, write_routes
from stucksolver_eval.scenarios.registry import SCENARIOS, load_all
from stucksolver_eval.sites.lane_walk import Town
from stucksolver_eval.sites.movements import movements
from stucksolver_eval.sites.site import Site
from stucksolver_eval.sites.suite_placement import SuitePlacement
from stucksolver_eval.suites import DATA
from stucksolver_eval.suites.weather_presets import weather

TOWNS = ("grid_town", "interurban", "motorway")
MAPS = DEMO_TOWN.parent
_OTHER_TOWNS = {"reported": ("grid_town", "interurban", "demo_town")}
"""Towns of a suite, where they differ from `TOWNS`."""
ROUTES_EACH = 5
_OTHER_COUNT = {"reported": 3}
"""Number of routes of each type, where it differs from `ROUTES_EACH`."""
_FIRST_ID = {"bench220": 1000, "immobilized": 3000, "reported": 5000}
"""First route id of each suite."""
_IDS_EACH = 10
"""Distance between the first ids of two types."""
_DECIMALS = 2
"""Number of decimals of positions."""


def main(arguments: list[str] | None = None) -> int:
    """Write or check the suites. Returns 1 if `--check` finds a difference, else 0."""
    parser = argparse.ArgumentParser(prog="python -m stucksolver_eval.suites.build", description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare only; do not write")
    check = parser.parse_args(arguments).check
    towns = load_towns()
    suites = {name: routes_of(name, towns) for name in _FIRST_ID}
    suites["dev"] = dev(suites["bench220"])
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) if check else DATA
        for name, placed in suites.items():
            if placed:
                write_routes(folder / f"{name}.xml", placed)
        written = sorted(folder.glob("*.xml"))
        differing = [path.name for path in written if path.read_bytes() != _bytes(DATA / path.name)]
    for name in differing:
        print(f"{name} differs. Run `python -m stucksolver_eval.suites.build`", file=sys.stderr)
    return 1 if differing else 0


def load_towns(folder: Path = MAPS) -> list[Town]:
    """Load the maps of the suites."""
    names = (*TOWNS, DEMO_TOWN.stem)
    return [Town(name, carla.Map(name, (folder / f"{name}.xodr").read_text("utf-8"))) for name in names]


def placed_in(suite: str) -> dict[str, SuitePlacement]:
    """Return the types that belong to a suite, ordered by id."""
    load_all()
    # An inherited `placed` belongs to another type.
    own = {name: vars(cls).get("placed") for name, cls in SCENARIOS.items()}
    found = {name: placed for name, placed in own.items() if placed is not None and placed.suite == suite}
    return dict(sorted(found.items(), key=lambda item: item[1].first_id))


def routes_of(suite: str, towns: Sequence[Town]) -> list[Route]:
    """Return the routes of each type of a suite. Raises `ValueError` if the maps have too few places for one."""
    towns = [town for town in towns if town.name in _OTHER_TOWNS.get(suite, TOWNS)]
    ways = {town.name: movements(town) for town in towns}
    routes = []
    for kind, placed in placed_in(suite).items():
        fitting = [town for town in towns if placed.only_in in ("", town.name)]
        sites = [site for town in fitting for site in placed.find(town, ways[town.name])]
        first = (placed.first_id - _FIRST_ID[suite]) // _IDS_EACH * ROUTES_EACH
        for number, site in enumerate(_spread(kind, sites, _OTHER_COUNT.get(suite, ROUTES_EACH))):
            routes.append(_route(kind, placed, site, first + number, placed.first_id + number))
    return routes


def dev(routes: Sequence[Route]) -> list[Route]:
    """Return one route of every second type, not always the first."""
    types = range(0, len(routes) // ROUTES_EACH, 2)
    return [routes[index * ROUTES_EACH + (index // 2) % ROUTES_EACH] for index in types]


def _spread(kind: str, sites: list[Site], count: int) -> list[Site]:
    """Return `count` sites on as many different lanes, junctions and maps as possible."""
    chance = random.Random(kind)
    chance.shuffle(sites)
    chosen: list[Site] = []
    while len(chosen) < count:
        if not sites:
            raise ValueError(f"{kind}: {len(chosen)} sites, {count} required. Add suitable roads to a map")
        chosen.append(min(sites, key=lambda site: _likeness(site, chosen)))
        sites = [site for site in sites if (site.town, site.place) != (chosen[-1].town, chosen[-1].place)]
    return chosen


def _likeness(site: Site, chosen: list[Site]) -> tuple[int, int, int]:
    """Return the numbers of chosen sites that start on the same lane, and at the same junction or road, or map."""
    here = [item for item in chosen if item.town is site.town]
    lane = (site.trigger.road_id, site.trigger.lane_id)
    same_lane = sum((item.trigger.road_id, item.trigger.lane_id) == lane for item in here)
    return same_lane, sum(item.group == site.group for item in here), len(here)


def _route(kind: str, placed: SuitePlacement, site: Site, number: int, route_id: int) -> Route:
    parameters = placed.draw(random.Random(f"{kind} {number}"), site.free_m)
    parameters.update({name: _xyz(where) for name, where in site.positions.items()})
    parameters.update(site.fixed)
    yaw_deg = math.remainder(site.trigger.transform.rotation.yaw, 360.0)
    trigger = RoutePose(_position(site.trigger), round(yaw_deg, _DECIMALS) + 0.0)
    spec = ScenarioSpec(f"{kind}_{number % ROUTES_EACH + 1}", kind, trigger, parameters)
    marks = tuple(_position(mark) for mark in site.marks)
    return Route(str(route_id), site.town.name, marks, weather(number), (spec,))


def _bytes(path: Path) -> bytes:
    return path.read_bytes() if path.exists() else b""


def _position(waypoint: carla.Waypoint) -> Position:
    place = waypoint.transform.location
    return Position(*(round(value, _DECIMALS) + 0.0 for value in (place.x, place.y, place.z)))


def _xyz(waypoint: carla.Waypoint) -> dict[str, str]:
    place = _position(waypoint)
    return {"x": str(place.x_m), "y": str(place.y_m), "z": str(place.z_m)}


if __name__ == "__main__":
    sys.exit(main())
