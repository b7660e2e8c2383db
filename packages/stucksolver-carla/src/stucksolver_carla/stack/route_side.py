"""Tells on which side the traffic of a route drives, and rejects routes for which that is not supported."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

from stucksolver_carla.drivers.behavior import RoutePoint

if TYPE_CHECKING:
    import carla

FIRST_CLIENT = "0.9.16"
"""First version of the client that reads the rule."""
_RULE = re.compile(r"<road\b[^>]*\brule\s*=\s*[\"']LHT[\"']")


class TrafficSideError(ValueError):
    """The side on which traffic drives is not supported on a route. The message names the remedy."""


def is_left_hand_route(carla_map: carla.Map, route: Sequence[RoutePoint]) -> bool:
    """Return True if the traffic of a route drives on the left.

    Raises:
        TrafficSideError: The traffic changes sides on the route, or this client ignores the map's left-hand traffic.
    """
    sides = {getattr(point.waypoint, "is_rht", None) for point in route}
    if None in sides:
        if _RULE.search(carla_map.to_opendrive()):
            raise TrafficSideError(
                f"the map has left-hand traffic, which this carla client ignores; install carla {FIRST_CLIENT} or later"
            )
        return False
    if len(sides) > 1:
        raise TrafficSideError(
            "a route from left-hand to right-hand traffic is not supported; end it where the side changes"
        )
    return not sides.pop()
