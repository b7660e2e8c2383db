"""Converts between CARLA's left-handed world (y south, yaw clockwise, degrees) and the local frame (y north, radians).

The local frame is the map's own right-handed frame: its origin is the map's, fixed for every episode.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import carla


def to_local(location: carla.Location) -> tuple[float, float]:
    """Return (x, y) of a `carla.Location`, or anything with x and y, in the local frame (m)."""
    return float(location.x), -float(location.y)


def yaw_to_local(yaw_deg: float) -> float:
    """Convert a CARLA yaw (degrees) to radians counter-clockwise."""
    return -math.radians(yaw_deg)


def to_world(x_m: float, y_m: float) -> tuple[float, float]:
    """Return (x, y) in CARLA's world of a point in the local frame (m)."""
    return x_m, -y_m
