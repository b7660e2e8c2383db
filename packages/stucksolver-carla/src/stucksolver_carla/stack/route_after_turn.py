"""Finds the start of a route for an ego that has turned around on the road."""

from __future__ import annotations

import math
from typing import Any

import carla

from stucksolver.scene import EgoState
from stucksolver_bridge.traffic_side import inner_lane
from stucksolver_carla.stack.alternative_routes import AlternativeRoute, road_ahead, route_length_m
from stucksolver_carla.stack.carla_frames import to_local
from stucksolver_carla.stack.route_road import SPACING_M, RouteRoad

BEHIND_M = 12.0
"""Distance behind the ego at which the new route starts (m): a turned ego is in the oncoming lane there. Ours."""

AGAINST_COS = -0.5
"""Cosine of the angle (120 degrees) from which a vehicle points against a lane. Ours."""


def route_after_turning(
    carla_map: carla.Map, road: RouteRoad, arc_m: float, ego: EgoState, destination: Any
) -> AlternativeRoute | None:
    """Return the route that starts in the oncoming lane behind the ego (local frame); None without such a lane.

    The route's length is None if no route leads from there to the destination, a `carla.Location`, without the road
    ahead.
    """
    last = len(road.stations) - 1
    behind, here = (road.stations[min(max(int(m / SPACING_M), 0), last)] for m in (arc_m - BEHIND_M, arc_m))
    if behind.junction or here.junction:
        return None
    start = _oncoming_lane(behind.waypoint)
    if start is None:
        return None
    x, y = to_local(start.transform.location)
    length_m = route_length_m(carla_map, start, destination, road_ahead(road, int(arc_m / SPACING_M)))
    return AlternativeRoute(start, "back", math.hypot(x - ego.x_m, y - ego.y_m), length_m)


def _oncoming_lane(waypoint: carla.Waypoint) -> carla.Waypoint | None:
    """Return the next lane in the opposite direction; None without one, or if it is not a driving lane."""
    inner = inner_lane(waypoint)
    while inner is not None and inner.lane_id * waypoint.lane_id > 0:
        inner = inner_lane(inner)
    return None if inner is None or inner.lane_type != carla.LaneType.Driving else inner


def points_along(waypoint: carla.Waypoint, vehicle_yaw_deg: float) -> bool:
    """Return True unless a vehicle with this yaw (CARLA's, degrees) points against the direction of a waypoint."""
    turn_rad = math.radians(waypoint.transform.rotation.yaw - vehicle_yaw_deg)
    return math.cos(turn_rad) > AGAINST_COS
