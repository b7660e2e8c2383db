"""Describes an observed vehicle to the solver: status, surroundings and scene."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stucksolver.scene import Status
from stucksolver_carla.observer.assumed_route import LENGTH_M, AssumedRoute
from stucksolver_carla.stack import CarlaSceneSource
from stucksolver_carla.stack.client_interface import EgoVehicle

if TYPE_CHECKING:
    pass

OFF_ROUTE_M = 2.5
"""Distance from the assumed route at which a new one is assumed (m): the vehicle turned or changed lanes. Ours."""
AHEAD_M = 250.0
"""Minimum length of the assumed route ahead (m). If less is left, a new route is assumed. Ours."""


class ObservedStack(CarlaSceneSource):
    """The scene source of an observed vehicle. It reads the world through the client, and applies and sets nothing.

    The route is unknown. It is assumed to follow the lane, and assumed again when the vehicle leaves it. So progress
    shows standstills but no circling, and there is no destination.
    """

    def __init__(self, vehicle: EgoVehicle) -> None:
        carla_map = vehicle.get_world().get_map()
        self._assumed_route = AssumedRoute(vehicle, carla_map)
        self._checked_at = _position(vehicle)
        super().__init__(vehicle, self._assumed_route, carla_map)

    def status(self) -> Status:
        here = _position(self._vehicle)
        moved_m = math.dist(here, self._checked_at)
        if moved_m > 1.0:
            self._checked_at = here
            if self._distance_to_route_m(here) > OFF_ROUTE_M or self.route_length_m < min(AHEAD_M, LENGTH_M / 2):
                self._assumed_route.update()
                self.take_route()
        return super().status().model_copy(update={"at_destination": False})

    def _distance_to_route_m(self, here: tuple[float, float]) -> float:
        """Return the distance to the nearest point of the assumed route (m)."""
        locations = (p.waypoint.transform.location for p in self._assumed_route.route)
        return min(math.hypot(p.x - here[0], p.y - here[1]) for p in locations)


def _position(vehicle: EgoVehicle) -> tuple[float, float]:
    location = vehicle.get_location()
    return float(location.x), float(location.y)
