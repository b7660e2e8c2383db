"""The cases: scenario type, position on the map, and the passenger's utterance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stucksolver_eval.actors.lane_path import straightest
from stucksolver_eval.streets.finder import choose_street

if TYPE_CHECKING:
    import carla

APPROACH_M = 30
"""Length of road before the obstacle (m). Ours."""
BEYOND_M = 70
"""Length of road beyond the obstacle (m). Ours."""


class CaseError(ValueError):
    """The map has no suitable position for a case. The message says what is missing."""


@dataclass(frozen=True)
class CaseLocation:
    """Waypoints 1 m apart, from the start to the destination, and the scenario's parameters."""

    waypoints: tuple[carla.Waypoint, ...]
    parameters: dict[str, float]


@dataclass(frozen=True)
class Case:
    """One case of the figure. `words`: time of the passenger's utterance (s since the start), and its text."""

    name: str
    title: str
    type: str
    find: Callable[[Any, Any], CaseLocation]
    """Finds the position in a `carla.World` and its `carla.Map`. Raises `CaseError` and `StreetError`."""
    words: tuple[float, str] | None = None
    drive_s: float = 60.0
    """Time limit of the drive (s). Ours."""
    shown_from_s: float = 0.0
    """Earliest decision in the figure (s since the start)."""


def _before_a_light(world: carla.World, carla_map: carla.Map) -> CaseLocation:
    """Find a traffic light with `APPROACH_M` of the same road before its stop line."""
    for light in sorted(world.get_actors().filter("traffic.traffic_light"), key=lambda item: item.id):
        for stop in light.get_stop_waypoints():
            before = stop.previous(float(APPROACH_M))
            if len(before) == 1 and not before[0].is_junction and before[0].road_id == stop.road_id:
                return CaseLocation(_waypoints_ahead(before[0], APPROACH_M + BEYOND_M), {})
    raise CaseError(f"no traffic light with {APPROACH_M} m of street before it: map {carla_map.name}. Use another map")


def _several_lanes(length_m: int, with_obstacle: bool) -> Callable[[Any, Any], CaseLocation]:
    """Return a finder of a street with a second lane of the same direction, with or without an obstacle on it."""

    def find(world: carla.World, carla_map: carla.Map) -> CaseLocation:
        street = choose_street(carla_map, "multi_lane", 1, length_m)
        return CaseLocation(street.waypoints, {"distance": float(street.obstacle_index)} if with_obstacle else {})

    return find


def _waypoints_ahead(waypoint: carla.Waypoint, distance_m: int) -> tuple[carla.Waypoint, ...]:
    """Return waypoints 1 m apart, as straight ahead as the junctions permit."""
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
    Case(
        "paper_bag",
        "A disabled car, and a paper bag in the lane beside it",
        "DisabledCarAndPaperBag",
        _several_lanes(170, True),
        drive_s=80.0,
    ),
)
