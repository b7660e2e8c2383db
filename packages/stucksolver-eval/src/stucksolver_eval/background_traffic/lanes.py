"""Lanes next to a route and entries of its junctions, read from the map."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeGuard

import carla

from stucksolver_bridge.traffic_side import inner_lane, outer_lane
from stucksolver_eval.routes.route_line import RouteLine

NARROWEST_M = 2.25
"""Smallest width of a lane with traffic (m)."""
MOST_LANES = 6
"""Maximum number of lanes on one side."""


@dataclass(frozen=True)
class RouteJunction:
    """A junction on the route: indices of the first and last route waypoint inside, and the junction's id."""

    first: int
    last: int
    number: int


def route_junctions(route: RouteLine) -> list[RouteJunction]:
    """Return the junctions of a route in driving order."""
    found: list[RouteJunction] = []
    for index, waypoint in enumerate(route.waypoints):
        if not waypoint.is_junction:
            continue
        number = int(waypoint.junction_id)
        if found and found[-1].number == number and index - found[-1].last < 4:
            found[-1] = RouteJunction(found[-1].first, index, number)
        else:
            found.append(RouteJunction(index, index, number))
    return found


def is_driving(waypoint: carla.Waypoint | None) -> TypeGuard[carla.Waypoint]:
    """Return True for a waypoint on a driving lane that is wide enough for traffic."""
    return waypoint is not None and waypoint.lane_type == carla.LaneType.Driving and waypoint.lane_width >= NARROWEST_M


def same_way(first: carla.Waypoint, second: carla.Waypoint) -> bool:
    """Return True if two lanes of the same road have the same direction."""
    return bool(first.lane_id * second.lane_id > 0)


def adjacent_lane(waypoint: carla.Waypoint, slot: int) -> carla.Waypoint | None:
    """Return the driving lane `slot` lanes toward the road's edge (negative: away from it), or None.

    The lane must have the same direction.
    """
    here = waypoint
    for _ in range(abs(slot)):
        there = outer_lane(here) if slot > 0 else inner_lane(here)
        if not is_driving(there) or not same_way(there, waypoint):
            return None
        here = there
    return here


def slots(waypoint: carla.Waypoint) -> list[int]:
    """Return the slots (see `adjacent_lane`) of all driving lanes with this direction. The waypoint's own lane is 0."""
    found = [0]
    for sign in (-1, 1):
        for k in range(1, MOST_LANES):
            if adjacent_lane(waypoint, sign * k) is None:
                break
            found.append(sign * k)
    return sorted(found)


def oncoming_lanes(waypoint: carla.Waypoint) -> list[carla.Waypoint]:
    """Return the driving lanes of the opposite direction on the same road, nearest first."""
    here = inner_lane(waypoint)
    found: list[carla.Waypoint] = []
    for _ in range(2 * MOST_LANES):
        if here is None or not same_way(here, waypoint):
            break
        here = inner_lane(here)
    for _ in range(MOST_LANES):
        if here is None or not is_driving(here) or same_way(here, waypoint):
            break
        found.append(here)
        here = outer_lane(here)
    return found


def back(waypoint: carla.Waypoint, distance_m: float, step_m: float = 5.0) -> Any | None:
    """Return the waypoint `distance_m` back along the lane; None if the lane ends or a junction is in between."""
    here, gone = waypoint, 0.0
    while gone < distance_m:
        step = min(step_m, distance_m - gone)
        before = here.previous(step)
        if not before or before[0].is_junction:
            return None
        here, gone = before[0], gone + step
    return None if here.is_junction else here


def entries(waypoint_in_junction: Any) -> Iterator[Any]:
    """Yield the last waypoint of every driving lane that leads into the waypoint's junction, each once."""
    yielded: set[tuple[int, int]] = set()
    for start, _ in waypoint_in_junction.get_junction().get_waypoints(carla.LaneType.Driving):
        for before in start.previous(1.0):
            key = (before.road_id, before.lane_id)
            if not before.is_junction and key not in yielded and is_driving(before):
                yielded.add(key)
                yield before
