"""The situations of a ride."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from stucksolver_eval.cases.case import CASES, CaseLocation
from stucksolver_eval.streets.finder import choose_street

ONCOMING = 3
"""Number of oncoming cars on streets with one lane each way. Ours."""


@dataclass(frozen=True)
class RideCase:
    """One situation. `map_name` is its default map; `find` finds its position on a map."""

    type: str
    map_name: str
    find: Callable[[Any, Any, int], CaseLocation]


def _street(length_m: int, obstacle: bool) -> Callable[[Any, Any, int], CaseLocation]:
    def find(world: Any, carla_map: Any, seed: int) -> CaseLocation:
        street = choose_street(carla_map, "any", seed, length_m)
        parameters = {"oncoming": float(ONCOMING if street.kind == "one_lane" else 0)}
        if obstacle:
            parameters["distance"] = float(street.obstacle_index)
        return CaseLocation(street.waypoints, parameters)

    return find


def _of_case(name: str) -> Callable[[Any, Any, int], CaseLocation]:
    case = next(item for item in CASES if item.name == name)
    return lambda world, carla_map, seed: case.find(world, carla_map)


RIDES = {
    "parked_car": RideCase("ParkedCarInLane", "demo_town", _street(170, True)),
    "cyclists": RideCase("SlowCyclists", "demo_town", _street(260, False)),
    "pedestrians": RideCase("PeopleAtRedLight", "grid_town", _of_case("pedestrians")),
    "open_door": RideCase("OpenDoorInLane", "grid_town", _of_case("open_door")),
}
