"""Status, surroundings and scene of a car that someone else drives."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stucksolver.scene import Status
from stucksolver_carla.observer.assumed_route import LENGTH_M, AssumedRoute
from stucksolver_carla.stack import CarlaSceneSource
from stucksolver_carla.stack.client_interface import EgoVehicle

if TYPE_CHECKING:
    pass

OFF_M = 2.5
"""Further than this from its assumed route, the car drives another one: it turned, or changed lane."""
AHEAD_M = 250.0
"""At least this much of the assumed route is kept ahead."""


class ObservedStack(CarlaSceneSource):
    """Reads the world through the client; applies, ticks and sets nothing.

    The route is unknown: it is assumed to follow the lane, and assumed again when the car goes elsewhere. So progress
    shows standstills but not circling, and there is no destination.
    """

    def __init__(self, vehicle: EgoVehicle) -> None:
        carla_map = vehicle.get_world().get_map()
        self._ahead = AssumedRoute(vehicle, carla_map)
        self._seen_at = _place(vehicle)
        super().__init__(vehicle, self._ahead, carla_map)

    def status(self) -> Status:
        here = _place(self._vehicle)
        driven = math.dist(here, self._seen_at)
        if driven > 1.0:
            self._seen_at = here
            if self._beside_m(here) > OFF_M or self.route_length_m < min(AHEAD_M, LENGTH_M / 2):
                self._ahead.look()
                self.take_route()
        return super().status().model_copy(update={"at_destination": False})

    def _beside_m(self, here: tuple[float, float]) -> float:
        """Distance from the nearest point of the assumed route."""
        places = (p.waypoint.transform.location for p in self._ahead.route)
        return min(math.hypot(p.x - here[0], p.y - here[1]) for p in places)


def _place(vehicle: EgoVehicle) -> tuple[float, float]:
    location = vehicle.get_location()
    return float(location.x), float(location.y)
