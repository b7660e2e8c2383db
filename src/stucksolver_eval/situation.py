"""Puts a stuck situation into a world: who stands or rides where, over the `carla` client API only."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

import carla

from stucksolver_eval.runlog import ActorRole
from stucksolver_eval.sites import Site
from stucksolver_eval.traffic import Traffic

LIFT_M = 0.3
"""Vehicles are put down from a little above the road, as CARLA's own scenarios do."""
CYCLIST_KMH = 9.0
CYCLISTS_AHEAD_M = (18, 23)
ONCOMING_FIRST_M, ONCOMING_SPACING_M = 60, 40
ONCOMING_SLOWER_PCT = 30.0


class Scenario(str, Enum):
    PARKED_CAR = "parked_car"
    CYCLISTS = "cyclists"


class SituationError(RuntimeError):
    """Something of a situation could not be put into the world."""


@dataclass
class Situation:
    """What was spawned; `ego` first."""

    ego: Any
    others: list[Any]
    traffic: list[Any]

    def role_of(self, actor_id: str) -> ActorRole:
        """What part an actor plays, for the replay."""
        if any(str(actor.id) == actor_id for actor in self.others):
            return "scenario"
        return "traffic" if any(str(actor.id) == actor_id for actor in self.traffic) else "prop"


def build(world: Any, site: Site, scenario: Scenario, oncoming: int, traffic: Traffic, seed: int) -> Situation:
    """Spawn the ego at the site's start and the scenario ahead of it. Raises `SituationError`."""
    ego = spawn(world, "vehicle.lincoln.mkz_2020", site.start, "hero")
    if scenario is Scenario.PARKED_CAR:
        others = [spawn(world, "vehicle.tesla.model3", site.obstacle, "scenario")]
        others[0].apply_control(carla.VehicleControl(hand_brake=True))
        cyclists = []
    else:
        blueprints = ("vehicle.diamondback.century", "vehicle.bh.crossbike")
        places = [site.waypoints[k] for k in CYCLISTS_AHEAD_M]
        cyclists = [spawn(world, b, w, "scenario") for b, w in zip(blueprints, places, strict=True)]
        others = cyclists
    cars = _oncoming(world, site, oncoming)
    world.tick()
    if cyclists or cars:
        _set_off(cyclists, cars, traffic.manager(seed))
    return Situation(ego, others, cars)


def _set_off(cyclists: list[Any], cars: list[Any], manager: Any) -> None:
    """Hand riders and cars to the client's TrafficManager."""
    for actor in (*cyclists, *cars):
        actor.set_autopilot(True, manager.get_port())
        manager.auto_lane_change(actor, False)
    for rider in cyclists:
        manager.set_desired_speed(rider, CYCLIST_KMH)
    for car in cars:
        manager.vehicle_percentage_speed_difference(car, ONCOMING_SLOWER_PCT)


def _oncoming(world: Any, site: Site, count: int) -> list[Any]:
    """Cars in the oncoming lane, from a little beyond the obstacle outwards, heading our way."""
    lane = site.obstacle.get_left_lane()
    cars: list[Any] = []
    if count == 0 or lane is None:
        return cars
    # Ahead of us is backwards along the oncoming lane.
    here: list[Any] = lane.previous(ONCOMING_FIRST_M)
    while here and len(cars) < count:
        car = _try_spawn(world, "vehicle.audi.a2", here[0], "background")
        if car is not None:
            cars.append(car)
        here = here[0].previous(ONCOMING_SPACING_M)
    return cars


def spawn(world: Any, blueprint: str, waypoint: Any, role: str, aside_m: float = 0.0) -> Any:
    """A vehicle on a waypoint, or to the right of it by `aside_m`. Raises `SituationError` where something is there."""
    actor = _try_spawn(world, blueprint, waypoint, role, aside_m)
    if actor is None:
        place = waypoint.transform.location
        raise SituationError(f"{blueprint} could not be put at ({place.x:.1f}, {place.y:.1f}): something is there")
    return actor


def _try_spawn(world: Any, blueprint: str, waypoint: Any, role: str, aside_m: float = 0.0) -> Any | None:
    definition = world.get_blueprint_library().find(blueprint)
    definition.set_attribute("role_name", role)
    transform = waypoint.transform
    transform.location += transform.get_right_vector() * aside_m + carla.Location(z=LIFT_M)
    actor = world.try_spawn_actor(definition, transform)
    if actor is not None:
        into_gear(actor)
    return actor


def into_gear(vehicle: Any) -> None:
    """Puts a new vehicle into first gear on the next tick, before any other control is applied.

    In CARLA it else takes a second with its first throttle, which is no standstill that anybody asks about.
    """
    vehicle.apply_control(carla.VehicleControl(manual_gear_shift=True, gear=1))
