"""The hero's state for the background traffic, updated a few times per second."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from stucksolver.scene.polyline import nearest_index
from stucksolver_bridge.traffic_side import drives_on_left
from stucksolver_eval.actors import Car
from stucksolver_eval.background_traffic.lanes import RouteJunction

if TYPE_CHECKING:
    import carla

    from stucksolver_eval.scenario_context import ScenarioContext

JUNCTION_NEAR_M = 30.0
"""Distance to a junction at which its traffic appears (m)."""
JUNCTION_NEAR_S = 1.5
"""Time headway in addition to that distance (s)."""
ROLE = "background"
_BEHIND, _AHEAD = 130, 160
"""Number of route waypoints behind and ahead of the hero within which cars are located on the route."""


@dataclass
class EgoSnapshot:
    """The hero on its route. `limit_mps` is the speed limit at the hero, which all background traffic uses."""

    setting: ScenarioContext
    index: int = 0
    s_m: float = 0.0
    speed_mps: float = 0.0
    limit_mps: float = 8.3
    junction: RouteJunction | None = None
    """The junction that the hero is in or reaches next."""
    junction_in_m: float = math.inf

    @cached_property
    def route_lanes(self) -> frozenset[tuple[int, int]]:
        """Road id and lane id of all lanes on the route."""
        return frozenset((w.road_id, w.lane_id) for w in self.setting.route.waypoints)

    @property
    def waypoint(self) -> Any:
        """The route waypoint that the hero has reached."""
        return self.setting.route.waypoints[self.index]

    @property
    def near_junction(self) -> bool:
        """True if the hero is close enough to the next junction for its traffic to appear."""
        return self.junction_in_m < JUNCTION_NEAR_M + JUNCTION_NEAR_S * self.speed_mps

    def spawn(self, waypoint: carla.Waypoint, speed_mps: float, **driving: Any) -> Car | None:
        """Spawn a moving background car on a lane. Returns None if the position is occupied."""
        cast, cars = self.setting.cast, self.setting.cars
        member = cast.spawn(cast.some_car(self.setting.random), waypoint.transform, role=ROLE)
        return None if member is None else cars.drive(member, waypoint, speed_mps, **driving)

    def along(self, car: Car) -> tuple[float, float]:
        """Return a car's distance ahead of the hero along the route, and from the route toward the road's edge (m)."""
        route, state = self.setting.route, self.setting.cast.state(car.member)
        first = max(self.index - _BEHIND, 0)
        best = first + nearest_index(route.xyz[first : self.index + _AHEAD], state.x, state.y)
        fx, fy = route.forward[best, :2]
        dx, dy = state.x - route.xyz[best, 0], state.y - route.xyz[best, 1]
        right_m = float(-dx * fy + dy * fx)
        edge_m = -right_m if drives_on_left(route.waypoints[best]) else right_m
        return float(route.s_m[best] + dx * fx + dy * fy - self.s_m), edge_m
