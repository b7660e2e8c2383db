"""What happens in each case: who stands, walks or rides where, and what a passenger says."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import carla

from stucksolver_eval.actors.path import straightest
from stucksolver_eval.sites import choose_site
from stucksolver_eval.situation import SituationError, spawn

APPROACH_M = 30.0
BEYOND_M = 70.0
WALK_MPS = 0.9
WALKERS = ("walker.pedestrian.0001", "walker.pedestrian.0017", "walker.pedestrian.0022")
"""Three adults of one size who look different: in CARLA each blueprint has one look."""


class CaseError(SituationError):
    """A case could not be staged on this map; the message says what is missing."""


@dataclass
class Staged:
    """Put into the world. `every_tick` is called with the seconds since the start."""

    ego: Any
    destination: Any
    every_tick: Callable[[float], None] = lambda seconds: None
    others: tuple[Any, ...] = ()
    """Whose way is told beside the ego's."""


@dataclass(frozen=True)
class Case:
    """One case of the figure. `words`: what a passenger says, and when."""

    name: str
    title: str
    stage: Callable[[Any, Any], Staged]
    words: tuple[float, str] | None = None
    drive_s: float = 60.0
    shown_from_s: float = 0.0
    """Decisions before this time are not the ones to show."""
    to_the_end: bool = False
    """Drive on after a decision, until the destination or the time is reached."""


def _pedestrians(world: Any, carla_map: Any) -> Staged:
    """A red light, and people on the crossing behind its stop line."""
    light, stop = _light_with_room(world)
    light.set_state(carla.TrafficLightState.Red)
    light.freeze(True)
    ego = spawn(world, "vehicle.lincoln.mkz_2020", stop.previous(APPROACH_M)[0], "hero")
    places = ((2.5, -5.5), (4.0, 6.5), (3.2, -8.0))
    walkers = [
        _walker(world, blueprint, stop.next(ahead)[0], side)
        for blueprint, (ahead, side) in zip(WALKERS, places, strict=True)
    ]

    def walk(seconds: float) -> None:
        for walker, (_, side) in zip(walkers, places, strict=True):
            if seconds >= 6.0:
                across = stop.transform.get_right_vector() * math.copysign(1.0, side)
                walker.apply_control(carla.WalkerControl(across, WALK_MPS))
        if seconds >= 30.0:
            light.set_state(carla.TrafficLightState.Green)

    return Staged(ego, _onward(stop, BEYOND_M).transform.location, walk)


def _open_door(world: Any, carla_map: Any) -> Staged:
    """A car that stands half in our lane, its door open towards us; the lane to the left is free."""
    site = choose_site(carla_map, "multi_lane", 1, 170)
    ego = spawn(world, "vehicle.lincoln.mkz_2020", site.start, "hero")
    parked = spawn(world, "vehicle.dodge.charger_2020", site.obstacle, "parked", aside_m=1.1)
    parked.apply_control(carla.VehicleControl(hand_brake=True))
    parked.open_door(carla.VehicleDoor.FL)
    return Staged(ego, site.destination.transform.location)


def _cyclists(world: Any, carla_map: Any) -> Staged:
    """Two cyclists ahead in our lane, slower than anyone; nobody is stuck, but a passenger would like to get on."""
    site = choose_site(carla_map, "multi_lane", 1, 260)
    ego = spawn(world, "vehicle.lincoln.mkz_2020", site.start, "hero")
    places = zip(("vehicle.diamondback.century", "vehicle.bh.crossbike"), (20, 25), strict=True)
    riders = [spawn(world, blueprint, site.waypoints[k], "rider") for blueprint, k in places]

    def ride(seconds: float) -> None:
        for rider in riders:
            rider.enable_constant_velocity(carla.Vector3D(x=2.5))

    return Staged(ego, site.destination.transform.location, ride, tuple(riders))


CASES = (
    Case("pedestrians", "Pedestrians cross at a red light", _pedestrians, shown_from_s=11.0),
    Case("open_door", "A door stands open into our lane", _open_door),
    Case(
        "cyclists",
        "Two slow cyclists, and a passenger in a hurry",
        _cyclists,
        words=(9.0, "please overtake them"),
    ),
)


def _light_with_room(world: Any) -> tuple[Any, Any]:
    """A light before whose stop line the lane goes straight for a while."""
    for light in sorted(world.get_actors().filter("traffic.traffic_light"), key=lambda one: one.id):
        for stop in light.get_stop_waypoints():
            before = stop.previous(APPROACH_M)
            if len(before) == 1 and not before[0].is_junction and before[0].road_id == stop.road_id:
                return light, stop
    raise CaseError(f"map {world.get_map().name} has no traffic light with {APPROACH_M:.0f} m of street before it")


def _onward(waypoint: Any, distance_m: float) -> Any:
    """As straight on as the junctions permit."""
    for _ in range(int(distance_m / 2.0)):
        options = waypoint.next(2.0)
        if not options:
            return waypoint
        waypoint = straightest(options)
    return waypoint


def _walker(world: Any, blueprint: str, waypoint: Any, side_m: float) -> Any:
    """A person beside the lane; positive to the left, as seen in the lane's direction."""
    definition = world.get_blueprint_library().find(blueprint)
    transform = waypoint.transform
    transform.location += transform.get_right_vector() * -side_m + carla.Location(z=1.0)
    walker = world.try_spawn_actor(definition, transform)
    if walker is None:
        raise CaseError("a pedestrian could not be put beside the crossing: something is there")
    return walker
