"""The three cases: which scenario type, where on the map, and what a passenger says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stucksolver_eval.actors.path import straightest
from stucksolver_eval.streets.find import choose_street

if TYPE_CHECKING:
    import carla

APPROACH_M = 30
BEYOND_M = 70


class CaseError(ValueError):
    """A case has no place on this map; the message says what is missing."""


@dataclass(frozen=True)
class Place:
    """`carla.Waypoint`s a metre apart, from the start to the destination, and the scenario's parameters."""

    waypoints: tuple[carla.Waypoint, ...]
    parameters: dict[str, float]


@dataclass(frozen=True)
class Case:
    """One case of the figure. `words`: what a passenger says, and when."""

    name: str
    title: str
    type: str
    find: Callable[[Any, Any], Place]
    """In a `carla.World` and its `carla.Map`. Raises `CaseError` and `StreetError`."""
    words: tuple[float, str] | None = None
    drive_s: float = 60.0
    shown_from_s: float = 0.0
    """Decisions before this time are not the ones to show."""


def _before_a_light(world: carla.World, carla_map: carla.Map) -> Place:
    """A light before whose stop line the lane goes straight for a while."""
    for light in sorted(world.get_actors().filter("traffic.traffic_light"), key=lambda one: one.id):
        for stop in light.get_stop_waypoints():
            before = stop.previous(float(APPROACH_M))
            if len(before) == 1 and not before[0].is_junction and before[0].road_id == stop.road_id:
                return Place(_onward(before[0], APPROACH_M + BEYOND_M), {})
    raise CaseError(f"map {carla_map.name} has no traffic light with {APPROACH_M} m of street before it; use another")


def _several_lanes(length_m: int, with_obstacle: bool) -> Callable[[Any, Any], Place]:
    """A street with a lane of our direction to the left, with something half-way along it or not."""

    def find(world: carla.World, carla_map: carla.Map) -> Place:
        street = choose_street(carla_map, "multi_lane", 1, length_m)
        return Place(street.waypoints, {"distance": float(street.obstacle_index)} if with_obstacle else {})

    return find


def _onward(waypoint: carla.Waypoint, distance_m: int) -> tuple[carla.Waypoint, ...]:
    """As straight on as the junctions permit, a waypoint each metre."""
    found = [waypoint]
    while len(found) <= distance_m and (options := found[-1].next(1.0)):
        found.append(straightest(options))
    return tuple(found)


CASES = (
    Case("pedestrians", "Pedestrians cross at a red light", "PeopleAtRedLight", _before_a_light, shown_from_s=11.0),
    Case("open_door", "A door stands open into our lane", "OpenDoorInLane", _several_lanes(170, True)),
    Case(
        "cyclists",
        "Two slow cyclists, and a passenger in a hurry",
        "SlowCyclists",
        _several_lanes(260, False),
        words=(9.0, "please overtake them"),
    ),
)
