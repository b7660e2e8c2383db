"""The side of the road on which traffic drives: OpenDRIVE's attribute `rule` of a road, `RHT` (default) or `LHT`."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

from carlette.errors import MapError

FIRST_CLIENT = "0.9.16"
"""First version of the client that reads the rule."""


def runs_back(waypoint: Any) -> bool:
    """Return True if the lane of a `carla.Waypoint` runs against the reference line of its road.

    Lanes with positive numbers are left of the line. They run back in right-hand traffic, and along it in left-hand
    traffic.
    """
    return bool((waypoint.lane_id > 0) == getattr(waypoint, "is_rht", True))


def check_traffic_side(root: ElementTree.Element, name: str, waypoint: Any) -> None:
    """Raise `MapError` for a map with left-hand traffic if the client gave a waypoint without the road's rule."""
    if not hasattr(waypoint, "is_rht") and any(road.get("rule") == "LHT" for road in root.iter("road")):
        raise MapError(
            f"map '{name}' has left-hand traffic, which the installed carla client ignores; "
            f"install carla {FIRST_CLIENT} or later"
        )
