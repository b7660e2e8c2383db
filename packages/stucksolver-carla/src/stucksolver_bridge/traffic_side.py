"""Tells on which side of the road traffic drives, from a waypoint. Python 3.7, standard library only.

The client reads OpenDRIVE's attribute `rule` of a road since version 0.9.16. Earlier ones treat all traffic as
right-hand traffic.
"""

from __future__ import annotations

from typing import Any


def drives_on_left(waypoint: Any) -> bool:
    """Return True if traffic drives on the left on the road of a waypoint."""
    return not getattr(waypoint, "is_rht", True)


def inner_lane(waypoint: Any) -> Any | None:
    """Return the adjacent lane toward oncoming traffic, on the left in right-hand traffic; None without one."""
    return waypoint.get_right_lane() if drives_on_left(waypoint) else waypoint.get_left_lane()


def outer_lane(waypoint: Any) -> Any | None:
    """Return the adjacent lane toward the road's edge, on the right in right-hand traffic; None without one."""
    return waypoint.get_left_lane() if drives_on_left(waypoint) else waypoint.get_right_lane()
