"""Detects objects that the ego pushes: they touch the ego and move with it."""

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
"""Gap between boxes that counts as contact (m). For CARLA's cars, boxes and bodies differ by up to this."""
MAX_RELATIVE_MPS = 1.0
"""Maximum relative speed of a pushed object (m/s). A faster one is brushed or hit, not pushed. Ours."""
EGO_MOVING_MPS = 0.2
"""Minimum speed of an ego that pushes (m/s). Ours."""
ACCELERATION_MPS = 0.3
"""Speed increase between two updates from which an object drives by itself (m/s). A pushed object slows down. Ours."""
STOPPED_MPS = 0.1
"""Speed below which a pushed object counts as stopped (m/s). Ours."""


class EgoFootprint(NamedTuple):
    """The ego's box and motion in CARLA's world frame (m, rad, m/s)."""

    x: float
    y: float
    z: float
    yaw: float
    half_length: float
    half_width: float
    vx: float
    vy: float


def footprint(vehicle: EgoVehicle) -> EgoFootprint:
    """Return the footprint of the ego."""
    transform, velocity, half = vehicle.get_transform(), vehicle.get_velocity(), vehicle.bounding_box.extent
    location, yaw = transform.location, math.radians(transform.rotation.yaw)
    return EgoFootprint(location.x, location.y, location.z, yaw, float(half.x), float(half.y), velocity.x, velocity.y)


class PushDetector:
    """Detects pushed objects. Call `update` with the objects around the ego; twice per second is enough."""

    def __init__(self) -> None:
        self.pushed_ids: frozenset[int] = frozenset()
        """Ids of the objects that were pushed at the last update."""
        self._rolling: dict[int, float] = {}
        """Speeds at the last update (m/s) of the objects that move because the ego pushed them, by id."""

    def update(self, ego: EgoFootprint, objects: NearbyObjects) -> frozenset[int]:
        """Return the ids of the objects that the ego pushes, and of pushed objects that still roll."""
        if not len(objects):
            self.pushed_ids, self._rolling = frozenset(), {}
            return self.pushed_ids
        gap = _gaps(ego, objects)
        relative_mps = np.hypot(objects.vx - ego.vx, objects.vy - ego.vy)
        pushes = math.hypot(ego.vx, ego.vy) > EGO_MOVING_MPS
        touched = (gap < TOUCH_M) & (relative_mps < MAX_RELATIVE_MPS) & pushes
        ids = objects.actor_id
        self.pushed_ids = frozenset(i for i, is_touched in zip(ids, touched.tolist(), strict=True) if is_touched)
        speed = dict(zip(ids, np.hypot(objects.vx, objects.vy).tolist(), strict=True))
        still_rolling = {
            i for i, last in self._rolling.items() if STOPPED_MPS < speed.get(i, 0.0) < last + ACCELERATION_MPS
        }
        self._rolling = {i: speed[i] for i in still_rolling | self.pushed_ids}
        return frozenset(self._rolling)


def _gaps(ego: EgoFootprint, objects: NearbyObjects) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the gap from the ego's box to each object's box (m); infinite for objects on another level."""
    half = (ego.half_length, ego.half_width)
    poses, halves = (objects.x, objects.y, objects.yaw), (objects.half_length, objects.half_width)
    gap = separation((ego.x, ego.y, ego.yaw), half, poses, halves)
    # The ego drives over lower boxes, and under higher ones such as bridges. Both heights (m) are ours.
    is_same_level = (objects.top > ego.z + 0.3) & (objects.bottom < ego.z + 1.5)
    return np.where(is_same_level, gap, np.inf)
