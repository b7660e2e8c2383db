"""Where a route may begin for a vehicle that has turned round on the road."""

from __future__ import annotations

import math
from typing import Any

import carla

from stucksolver.scene import EgoState
from stucksolver_carla.stack.alternative_routes import AlternativeRoute, road_ahead, route_length_m
from stucksolver_carla.stack.carla_frames import to_local
from stucksolver_carla.stack.route_road import SPACING_M, RouteRoad

BEHIND_M = 12.0
"""The new route begins this far behind the ego: a turned vehicle is in the other lane by then."""

AGAINST_COS = -0.5
"""Cosine of the smallest angle (120 degrees) at which a vehicle faces the other way."""


def way_back(
    carla_map: carla.Map, road: RouteRoad, arc_m: float, ego: EgoState, destination: Any
) -> AlternativeRoute | None:
    """Return the lane of the other direction beside the route, behind the ego (local frame), or None.

    Its length is None if no route leads from there to the `carla.Location` without the road ahead.
    """
    last = len(road.stations) - 1
    behind, here = (road.stations[min(max(int(m / SPACING_M), 0), last)] for m in (arc_m - BEHIND_M, arc_m))
    if behind.junction or here.junction:
        return None
    start = _other_direction(behind.waypoint)
    if start is None:
        return None
    x, y = to_local(start.transform.location)
    length_m = route_length_m(carla_map, start, destination, road_ahead(road, int(arc_m / SPACING_M)))
    return AlternativeRoute(start, "back", math.hypot(x - ego.x_m, y - ego.y_m), length_m)


def _other_direction(waypoint: carla.Waypoint) -> carla.Waypoint | None:
    """Return the next driving lane to the left in the other direction."""
    beside = waypoint.get_left_lane()
    while beside is not None and beside.lane_id * waypoint.lane_id > 0:
        beside = beside.get_left_lane()
    return None if beside is None or beside.lane_type != carla.LaneType.Driving else beside


def faces(waypoint: carla.Waypoint, vehicle_yaw_deg: float) -> bool:
    """True unless a vehicle with that yaw (CARLA's, degrees) points against the direction of a waypoint."""
    turned = math.radians(waypoint.transform.rotation.yaw - vehicle_yaw_deg)
    return math.cos(turned) > AGAINST_COS
