"""Defines the options of a driver that are not part of its behavior profile."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DriverOptions:
    """Margins and switches; lengths in meters."""

    ignore_traffic_lights: bool = False
    """True to drive through red lights."""
    follow_obeys_lights: bool = True
    """True to stop at red lights and stop signs of the route also while the ego follows a set path."""
    side_margin_m: float = 0.3
    """Required clearance at the ego's sides in the route's lane. Ours."""
    follow_side_margin_m: float = 0.2
    """Required clearance at the ego's sides on a set path: an object at 0.3 m never stops the ego. Ours."""
    follow_gap_m: float = 1.5
    """Bumper gap to stopped objects in a set path. Ours."""
    follow_deceleration: float = 3.0
    """Comfortable deceleration on a set path (m/s²). Ours."""
    heeds_on_path: bool = True
    """True to brake for obstacles in a set path. If False, the planner of the path is responsible for them."""
    stop_line_gap_m: float = 1.0
    """Distance from the front bumper to a red light's stop line. Ours."""
