"""Detects what the ego pushes: it touches it, and both move as one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stucksolver.scene.boxes import separation
from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.stack.client_interface import EgoVehicle

if TYPE_CHECKING:
    pass

TOUCH_M = 0.2
"""Boxes are a little larger or smaller than bodies: by up to this for CARLA's cars."""
AS_ONE_MPS = 1.0
"""With a larger difference in velocity it is brushed or struck, not pushed."""
PUSHES_MPS = 0.2
SPEEDS_UP_MPS = 0.3
"""A pushed object rolls slower and slower until it stands; one that accelerates drives by itself."""
STANDS_MPS = 0.1


class EgoFootprint(NamedTuple):
    """The ego's box and motion in CARLA's world: meters, radians, m/s."""

    x: float
    y: float
    z: float
    yaw: float
    half_length: float
    half_width: float
    vx: float
    vy: float


def footprint(vehicle: EgoVehicle) -> EgoFootprint:
    """Return the footprint of the ego, or of a stand-in for one."""
    transform, velocity, half = vehicle.get_transform(), vehicle.get_velocity(), vehicle.bounding_box.extent
    place, yaw = transform.location, math.radians(transform.rotation.yaw)
    return EgoFootprint(place.x, place.y, place.z, yaw, float(half.x), float(half.y), velocity.x, velocity.y)


class PushDetector:
    """Call `look` with the bodies around; twice a second is enough."""

    def __init__(self) -> None:
        self.now: frozenset[int] = frozenset()
        """Ids of what was pushed at the last look."""
        self._rolling: dict[int, float] = {}
        """Speed at the last look of everything that moves because it was pushed."""

    def look(self, ego: EgoFootprint, seen: NearbyObjects) -> frozenset[int]:
        """Return the ids of what moves because the ego pushes it, or pushed it a moment ago and it still rolls."""
        if not len(seen):
            self.now, self._rolling = frozenset(), {}
            return self.now
        gap = _gaps(ego, seen)
        apart = np.hypot(seen.vx - ego.vx, seen.vy - ego.vy)
        pushes = math.hypot(ego.vx, ego.vy) > PUSHES_MPS
        touched = (gap < TOUCH_M) & (apart < AS_ONE_MPS) & pushes
        self.now = frozenset(i for i, item in zip(seen.actor_id, touched.tolist(), strict=True) if item)
        speed = dict(zip(seen.actor_id, np.hypot(seen.vx, seen.vy).tolist(), strict=True))
        rolls_on = {i for i, last in self._rolling.items() if STANDS_MPS < speed.get(i, 0.0) < last + SPEEDS_UP_MPS}
        self._rolling = {i: speed[i] for i in rolls_on | self.now}
        return frozenset(self._rolling)


def _gaps(ego: EgoFootprint, seen: NearbyObjects) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the gap from the ego's box to each body (m); infinite for those on another level."""
    half = (ego.half_length, ego.half_width)
    gap = separation((ego.x, ego.y, ego.yaw), half, (seen.x, seen.y, seen.yaw), (seen.half_length, seen.half_width))
    # Lower bodies are driven over, and higher ones are bridges.
    level = (seen.top > ego.z + 0.3) & (seen.bottom < ego.z + 1.5)
    return np.where(level, gap, np.inf)
