"""Assumes a route for an observed vehicle: along its lane, straight on at forks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from stucksolver_carla.drivers.behavior import RoutePoint
from stucksolver_carla.stack.client_interface import EgoVehicle

if TYPE_CHECKING:
    import carla

STEP_M = 1.0
"""Distance between two points of the route (m), as in other routes."""
LENGTH_M = 400
"""Length of the assumed route (m). Ours."""


class AssumedRoute:
    """The assumed route of an observed vehicle."""

    def __init__(self, vehicle: EgoVehicle, carla_map: carla.Map) -> None:
        self._vehicle = vehicle
        self._map = carla_map
        self.route: Sequence[RoutePoint] = ()
        self.update()

    def update(self) -> None:
        """Assume a new route from the vehicle's position."""
        waypoint = self._map.get_waypoint(self._vehicle.get_location())
        points = [RoutePoint(waypoint, "lane_follow")]
        for _ in range(LENGTH_M):
            next_waypoints = waypoint.next(STEP_M)
            if not next_waypoints:
                break
            turns_deg = [_turn_deg(waypoint, other) for other in next_waypoints]
            waypoint = next_waypoints[turns_deg.index(min(turns_deg))]
            points.append(RoutePoint(waypoint, "lane_follow"))
        self.route = points


def _turn_deg(here: carla.Waypoint, other: carla.Waypoint) -> float:
    """Return the angle between the directions of two waypoints (degrees)."""
    return abs(math.remainder(other.transform.rotation.yaw - here.transform.rotation.yaw, 360.0))
