"""Near misses. All numbers use one definition: TTC below 1 s, or a gap below 0.3 m.

Both are to a moving actor. TTC (time to collision) is the time to contact of the two boxes if both keep their velocity
and heading.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stucksolver.scene.boxes import HalfSize, Pose, separation, time_to_contact
from stucksolver_carla.drivers.behavior.nearby_objects import GroundTruthObjects, NearbyObjects
from stucksolver_eval.results.outcome import TimedInfraction

if TYPE_CHECKING:
    import carla

MOVING_MPS = 0.1
"""Speed from which an actor counts as moving (m/s). Ours."""
NEAR_GAP_M = 0.3
"""Gap below which there is a near miss (m). Ours."""
NEAR_TTC_S = 1.0
"""TTC below which there is a near miss (s). Ours."""
LOOK_EVERY_S = 0.2
"""Interval between two checks (s). Ours."""
LOOK_RANGE_M = 40.0
"""Distance within which actors are checked (m). Ours."""
BELOW_M, ABOVE_M = 1.0, 2.5
"""Largest depth below and height above the ego at which an actor is on the same level of the road (m). Ours."""

Velocity = tuple[Any, Any]
"""(vx, vy), m/s: arrays or numbers that broadcast together."""


def is_near(ego: Pose, ego_mps: Velocity, ego_half: HalfSize, others: Pose, mps: Velocity, half: HalfSize) -> Any:
    """Return for each of the others whether it is a near miss. Arrays, in any fixed frame."""
    moving = np.hypot(*mps) > MOVING_MPS
    gap = separation(ego, ego_half, others, half)
    relative = (mps[0] - ego_mps[0], mps[1] - ego_mps[1])
    return moving & ((gap < NEAR_GAP_M) | (time_to_contact(ego, ego_half, others, half, relative) < NEAR_TTC_S))


class NearMissWatch:
    """Counts each near miss once while it lasts, and again after a separation."""

    def __init__(self, world: carla.World, ego: carla.Vehicle) -> None:
        self._perception = GroundTruthObjects(world, ego.id, LOOK_RANGE_M)
        box = ego.bounding_box.extent
        self._half = (float(box.x), float(box.y))
        self._next_s = 0.0
        self._near: frozenset[int] = frozenset()
        self.found: list[TimedInfraction] = []

    def update(self, time_s: float, transform: carla.Transform, velocity: carla.Vector3D) -> None:
        """Check the surroundings, five times per second.

        `transform` and `velocity` are the ego's, from the `carla` client.
        """
        if time_s < self._next_s - 1e-6:
            return
        self._next_s = time_s + LOOK_EVERY_S
        place = transform.location
        objects = self._perception.read(place.x, place.y)
        near = self._near_ones(objects, transform, velocity) if len(objects) else frozenset()
        for actor_id in sorted(near - self._near):
            self.found.append(
                TimedInfraction(kind="near_miss", time_s=round(time_s, 2), text=f"near miss with actor {actor_id}")
            )
        self._near = near

    def _near_ones(
        self, objects: NearbyObjects, transform: carla.Transform, velocity: carla.Vector3D
    ) -> frozenset[int]:
        place, yaw = transform.location, math.radians(transform.rotation.yaw)
        level = (objects.top > place.z - BELOW_M) & (objects.bottom < place.z + ABOVE_M)
        near = level & is_near(
            (place.x, place.y, yaw),
            (velocity.x, velocity.y),
            self._half,
            (objects.x, objects.y, objects.yaw),
            (objects.vx, objects.vy),
            (objects.half_length, objects.half_width),
        )
        return frozenset(objects.actor_id[int(i)] for i in np.flatnonzero(near))
