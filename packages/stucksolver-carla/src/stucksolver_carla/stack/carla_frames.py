"""Converts between CARLA's left-handed world frame (y south, yaw clockwise, degrees) and the local frame.

The local frame is the map's right-handed frame (y north, yaw counter-clockwise, radians). Its origin is the map's.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import carla


def to_local(location: carla.Location) -> tuple[float, float]:
    """Return (x, y) in the local frame (m) of a `carla.Location` or of another object with x and y."""
    return float(location.x), -float(location.y)


def yaw_to_local(yaw_deg: float) -> float:
    """Return a CARLA yaw (degrees) as radians counter-clockwise."""
    return -math.radians(yaw_deg)


def to_world(x_m: float, y_m: float) -> tuple[float, float]:
    """Return (x, y) in CARLA's world frame of a point in the local frame (m)."""
    return x_m, -y_m
