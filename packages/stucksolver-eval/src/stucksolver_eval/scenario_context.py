"""Context of scenarios and background traffic: the world, the route, and the actors."""

from __future__ import annotations

import random
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from stucksolver_eval.actors import ActorPool, SimulatedCars
from stucksolver_eval.routes.route_line import RouteLine

if TYPE_CHECKING:
    import carla


@dataclass
class ScenarioContext:
    """One route in one world. `client`, `world`, `map` and `hero` are objects of the `carla` client.

    The world is in synchronous mode with `dt_s` as its fixed step.
    """

    client: carla.Client
    world: carla.World
    map: carla.Map
    hero: carla.Vehicle
    route: RouteLine
    random: random.Random
    dt_s: float = 0.05
    hero_s_m: float = 0.0
    """Position of the ego along the route (m); updated by `ScenarioPlayer`."""

    @cached_property
    def cast(self) -> ActorPool:
        """All actors that scenarios and background traffic create."""
        return ActorPool(self.client, self.world, self.hero)

    @cached_property
    def cars(self) -> SimulatedCars:
        """The actors that drive."""
        return SimulatedCars(self.cast, self.dt_s)
