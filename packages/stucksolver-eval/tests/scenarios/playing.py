"""Plays a scenario of the shipped suite on a server, from just before its trigger, with a hero that does as told."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import carla
import numpy as np

import stucksolver_eval.suites as suites
from stucksolver_eval.actors import Car, ScenarioActor
from stucksolver_eval.background_traffic import Background
from stucksolver_eval.routes import Route, ScenarioSpec, read_routes
from stucksolver_eval.routes.route_line import RouteLine
from stucksolver_eval.scenarios import Scenario, ScenarioContext, ScenarioPlayer

TICK_S = 0.05
HERO = "vehicle.lincoln.mkz_2020"


@lru_cache(maxsize=1)
def shipped() -> dict[str, Route]:
    """Routes of the suite by the name of their scenario."""
    file = Path(suites.__file__).parent / "data" / "bench220.xml"
    return {route.scenarios[0].name: route for route in read_routes(file)}


class Playing:
    """One play. `hero_s` is along the route, which begins `before_m` ahead of the trigger."""

    def __init__(
        self, world: Any, route: Route, client: Any, before_m: float = 5.0, traffic: bool = True, **parameters: Any
    ) -> None:
        settings = world.get_settings()
        settings.synchronous_mode, settings.fixed_delta_seconds = True, TICK_S
        world.apply_settings(settings)
        self.world, self.map = world, world.get_map()
        spec = route.scenarios[0]
        self.spec = ScenarioSpec(spec.name, spec.type, spec.trigger, {**spec.parameters, **parameters})
        self.route = _from_trigger(RouteLine.trace(self.map, route.waypoints), self.spec, before_m)
        self.hero = _hero(world, self.route)
        world.tick()
        self.setting = ScenarioContext(client, world, self.map, self.hero, self.route, random.Random(1))
        self.background = Background(self.setting) if traffic else None
        self.play = ScenarioPlayer([self.spec], self.setting, self.background)
        self._index = 0
        self._car: Car | None = None

    @property
    def scenario(self) -> Scenario:
        return self.play._parts[0].scenario

    @property
    def cast(self) -> Any:
        return self.setting.cast

    @property
    def hero_s(self) -> float:
        return float(self.route.s_m[self._index])

    def tick(self) -> None:
        self.world.tick()
        self._index = self.route.project(self.hero.get_location(), self._index)
        self.play.tick(self.world.get_snapshot().timestamp.elapsed_seconds, self.hero_s)

    def run(self, seconds: float, until: Callable[[], bool] | None = None) -> bool:
        """Tick for a while; whether `until` came true."""
        for _ in range(round(seconds / TICK_S)):
            self.tick()
            if until is not None and until():
                return True
        return False

    def go(self, speed_mps: float) -> None:
        """Let the hero drive its route at a constant speed, whatever comes."""
        if self._car is None:
            line = self.route.waypoints[self._index :]
            self._car = self.setting.cars.drive(
                self.cast.hero_member, line, speed_mps, yields=False, obeys_lights=False, ends=True
            )
        self._car.wish_mps = speed_mps

    def jump(self, s_m: float) -> None:
        """Put the hero, standing, at a place of its route, and make a tick."""
        place = self.route.waypoint_at(s_m).transform
        place.location.z += 0.2
        self.hero.set_transform(place)
        self.hero.set_target_velocity(carla.Vector3D())
        self.world.tick()
        self._index = self.route.index_at(s_m)
        self.tick()

    def others(self, prefix: str = "vehicle.") -> list[ScenarioActor]:
        """Members of the scenario above ground, in the order of their coming."""
        return [
            member
            for member in self.cast.members.values()
            if member.type_id.startswith(prefix)
            and not member.is_staged
            and member.actor.attributes.get("role_name") == "scenario"
        ]

    def along(self, member: ScenarioActor) -> tuple[float, float]:
        """(arc length on the route, meters right of it) of an actor."""
        state = self.cast.state(member)
        gaps = (self.route.xyz[:, 0] - state.x) ** 2 + (self.route.xyz[:, 1] - state.y) ** 2
        index = int(np.argmin(gaps))
        fx, fy = self.route.forward[index, :2]
        dx, dy = state.x - self.route.xyz[index, 0], state.y - self.route.xyz[index, 1]
        return float(self.route.s_m[index] + dx * fx + dy * fy), float(-dx * fy + dy * fx)

    def facing_deg(self, member: ScenarioActor) -> float:
        """Heading of an actor against the route beside it, in [0, 180]."""
        state = self.cast.state(member)
        waypoint = self.map.get_waypoint(carla.Location(*self.route.xyz[self.route.index_at(self.along(member)[0])]))
        return abs(
            math.degrees(math.remainder(state.yaw_rad - math.radians(waypoint.transform.rotation.yaw), math.tau))
        )

    def apart_m(self, member: ScenarioActor) -> float:
        """Distance between the hero's middle and an actor's."""
        hero, state = self.cast.hero, self.cast.state(member)
        return float(hero.distance_m(state.x, state.y))

    def close(self) -> None:
        self.play.close()
        if self.hero.is_alive:
            self.hero.destroy()


class Theatre:
    """Servers by town, each started when first needed, and one play at a time on them."""

    def __init__(self, client_of: Callable[[str], Any]) -> None:
        self._client_of = client_of

    def play(self, name: str, **options: Any) -> Playing:
        """A route of the suite by the name of its scenario: `Accident_1`."""
        route = shipped()[name]
        client = self._client_of(route.town)
        return Playing(client.load_world(route.town), route, client, **options)


def _from_trigger(line: RouteLine, spec: ScenarioSpec, before_m: float) -> RouteLine:
    place = spec.trigger.position
    index = line.project(carla.Location(place.x_m, place.y_m, place.z_m))
    first = line.index_at(max(float(line.s_m[index]) - before_m, 0.0))
    return RouteLine.along(line.points[first:])


def _hero(world: Any, route: RouteLine) -> Any:
    blueprint = world.get_blueprint_library().find(HERO)
    blueprint.set_attribute("role_name", "hero")
    start = route.waypoints[0].transform
    start.location.z += 0.3
    return world.spawn_actor(blueprint, start)
