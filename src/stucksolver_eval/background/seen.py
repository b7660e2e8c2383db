"""What the parts of the traffic know of the hero, looked up a few times a second."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from stucksolver.scene.polyline import nearest_index
from stucksolver_eval.actors import Car
from stucksolver_eval.background.lanes import RouteJunction

if TYPE_CHECKING:
    import carla

    from stucksolver_eval.setting import Setting

JUNCTION_NEAR_M = 30.0
JUNCTION_NEAR_S = 1.5
ROLE = "background"
_BEHIND, _AHEAD = 130, 160
"""Waypoints of the route within which cars are placed along it."""


@dataclass
class Seen:
    """The hero on its route. Speeds in m/s; `limit_mps` is the hero's speed limit, which all traffic goes by."""

    setting: Setting
    index: int = 0
    s_m: float = 0.0
    speed_mps: float = 0.0
    limit_mps: float = 8.3
    junction: RouteJunction | None = None
    """The one it is in or comes to next."""
    junction_in_m: float = math.inf

    @cached_property
    def route_lanes(self) -> frozenset[tuple[int, int]]:
        """Road and lane of all that the route drives on."""
        return frozenset((w.road_id, w.lane_id) for w in self.setting.route.waypoints)

    @property
    def waypoint(self) -> Any:
        """The route's waypoint that the vehicle has reached."""
        return self.setting.route.waypoints[self.index]

    @property
    def near_junction(self) -> bool:
        """Whether the next junction counts already."""
        return self.junction_in_m < JUNCTION_NEAR_M + JUNCTION_NEAR_S * self.speed_mps

    def spawn(self, waypoint: carla.Waypoint, speed_mps: float, **driving: Any) -> Car | None:
        """A background car on a lane, under way; None where there is no room."""
        cast, cars = self.setting.cast, self.setting.cars
        member = cast.spawn(cast.some_car(self.setting.random), waypoint.transform, role=ROLE)
        return None if member is None else cars.drive(member, waypoint, speed_mps, **driving)

    def along(self, car: Car) -> tuple[float, float]:
        """(metres ahead of the hero along the route, metres right of the route) of a car near the route."""
        route, state = self.setting.route, self.setting.cast.state(car.member)
        first = max(self.index - _BEHIND, 0)
        best = first + nearest_index(route.xyz[first : self.index + _AHEAD], state.x, state.y)
        fx, fy = route.forward[best, :2]
        dx, dy = state.x - route.xyz[best, 0], state.y - route.xyz[best, 1]
        return float(route.s_m[best] + dx * fx + dy * fy - self.s_m), float(-dx * fy + dy * fx)
