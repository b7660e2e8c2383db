"""The route that an observer assumes: along the car's lane, straight on where the road divides."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from stucksolver_carla.drivers.behavior import RoutePoint
from stucksolver_carla.stack.client_interface import EgoVehicle

if TYPE_CHECKING:
    import carla

STEP_M = 1.0
LENGTH_M = 400


class AssumedRoute:
    """The assumed route of a car that someone else drives."""

    def __init__(self, vehicle: EgoVehicle, carla_map: carla.Map) -> None:
        self._vehicle = vehicle
        self._map = carla_map
        self.route: Sequence[RoutePoint] = ()
        self.look()

    def look(self) -> None:
        """Assume a new route from the car's position."""
        waypoint = self._map.get_waypoint(self._vehicle.get_location())
        found = [RoutePoint(waypoint, "lane_follow")]
        for _ in range(LENGTH_M):
            onwards = waypoint.next(STEP_M)
            if not onwards:
                break
            turns = [_turn(waypoint, other) for other in onwards]
            waypoint = onwards[turns.index(min(turns))]
            found.append(RoutePoint(waypoint, "lane_follow"))
        self.route = found


def _turn(here: carla.Waypoint, other: carla.Waypoint) -> float:
    """How far a waypoint turns away from another, degrees."""
    return abs(math.remainder(other.transform.rotation.yaw - here.transform.rotation.yaw, 360.0))
