"""What a scenario may touch: the world, the route, the cast, and the traffic around."""

from __future__ import annotations

import random
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from stucksolver_eval.actors import Cars, Cast
from stucksolver_eval.routes.line import RouteLine

if TYPE_CHECKING:
    from stucksolver_eval.background import Background


@dataclass
class Setting:
    """One route in one world. `client`, `world`, `map` and `hero` are objects of the `carla` client.

    The world is in synchronous mode with `dt_s` as its fixed step. `background` may be set after the setting is
    made: `setting.background = Background(setting)`; `Play` moves it.
    """

    client: Any
    world: Any
    map: Any
    hero: Any
    route: RouteLine
    random: random.Random
    background: Background | None = None
    dt_s: float = 0.05
    hero_s_m: float = 0.0
    """Where the hero is along the route; `Play` keeps it."""

    @cached_property
    def cast(self) -> Cast:
        """Everyone that scenarios and background put into the world."""
        return Cast(self.client, self.world, self.hero)

    @cached_property
    def cars(self) -> Cars:
        """Those of the cast that drive."""
        return Cars(self.cast, self.dt_s)
