"""Options of a driver that do not change its behavior profile."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DriverOptions:
    """Margins and switches; lengths in meters."""

    ignore_traffic_lights: bool = False
    follow_obeys_lights: bool = True
    """Stop at red lights and stop signs of the route while driving a given path, too."""
    side_margin_m: float = 0.3
    """Clearance that the route's lane must have on either side of the body."""
    follow_side_margin_m: float = 0.2
    """The same on a given path: an object 0.3 m beside it never stops the ego."""
    follow_gap_m: float = 1.5
    """Bumper gap kept to standing objects in a given path."""
    follow_deceleration: float = 3.0
    """Comfortable braking on a given path (m/s²)."""
    heeds_on_path: bool = True
    """Brake for what is in the way on a given path, too. Without it, whoever gave the path is responsible."""
    stop_line_gap_m: float = 1.0
    """Distance from the front bumper to a red light's stop line."""
