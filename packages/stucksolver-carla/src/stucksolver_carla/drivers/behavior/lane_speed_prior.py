"""Corrects the speed of new and of camera tracks with the speeds of earlier vehicles on the same path.

At the edge of the LiDAR's grid, speeds are measured too low at first: 10 to 14 m/s of 20. An ego that starts in front
of such a vehicle because it seems slow gets in its way. The camera alone gives an upper bound, up to twice the speed.
With that bound, the ego would reject good gaps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath
from stucksolver_carla.drivers.behavior.conflicting_traffic import ConflictingVehicle
from stucksolver_carla.drivers.behavior.nearby_objects import FIRST_FAR_ID

NEW_TRACK_S = 0.7
"""Time after its first detection on a path for which a vehicle is new (s). Ours."""
PACE_S = 5.0
"""Time without a vehicle after which the usual speed of a path is forgotten (s). Ours."""
FASTER_MPS = 2.0
"""Maximum speed of a camera track above the fastest earlier vehicle on its path (m/s). Ours."""
MIN_VEHICLES = 2
"""Minimum number of earlier vehicles for that limit. Ours."""
MEMORY_S = 12.0
"""Time within which these vehicles drove there (s). Ours."""


class LaneSpeedPrior:
    """Speeds of earlier vehicles on the paths of one junction."""

    def __init__(self) -> None:
        self._first_seen_s: dict[tuple[int, int], float] = {}
        self._path_speeds: dict[int, tuple[float, float]] = {}
        """For each path: the time of the last vehicle (s), and the median speed at that time (m/s)."""
        self._vehicle_speeds: dict[int, dict[int, tuple[float, float]]] = {}
        """For each path and vehicle: the time of its last detection (s), and its highest speed (m/s)."""

    def with_prior_speed(
        self, pairs: Sequence[tuple[ConflictPath, ConflictingVehicle]], now_s: float
    ) -> list[tuple[ConflictPath, ConflictingVehicle]]:
        """Return the pairs with corrected speeds.

        New vehicles get the usual speed of their path if they seem slower. Camera tracks get little more than the
        highest earlier speed if they seem faster.
        """
        self._first_seen_s = {
            (id(path), vehicle.actor_id): self._first_seen_s.get((id(path), vehicle.actor_id), now_s)
            for path, vehicle in pairs
        }
        speeds: dict[int, list[float]] = {}
        for path, vehicle in pairs:
            if vehicle.actor_id < FIRST_FAR_ID and not self._is_new(path, vehicle, now_s):
                speeds.setdefault(id(path), []).append(vehicle.speed)
                vehicle_speeds = self._vehicle_speeds.setdefault(id(path), {})
                vehicle_speeds[vehicle.actor_id] = (
                    now_s,
                    max(vehicle.speed, vehicle_speeds.get(vehicle.actor_id, (0.0, 0.0))[1]),
                )
        self._path_speeds |= {path: (now_s, float(np.median(values))) for path, values in speeds.items()}
        return [(path, self._corrected(path, vehicle, now_s)) for path, vehicle in pairs]

    def _is_new(self, path: ConflictPath, vehicle: ConflictingVehicle, now_s: float) -> bool:
        return now_s - self._first_seen_s[id(path), vehicle.actor_id] < NEW_TRACK_S

    def _corrected(self, path: ConflictPath, vehicle: ConflictingVehicle, now_s: float) -> ConflictingVehicle:
        speed = (
            max(vehicle.speed, self._usual_mps(id(path), now_s))
            if self._is_new(path, vehicle, now_s)
            else vehicle.speed
        )
        limit_mps = self._camera_limit_mps(id(path), now_s) if vehicle.actor_id >= FIRST_FAR_ID else math.inf
        return vehicle._replace(speed=min(speed, limit_mps))

    def _usual_mps(self, path: int, now_s: float) -> float:
        last_s, median_mps = self._path_speeds.get(path, (now_s, 0.0))
        return median_mps if now_s - last_s < PACE_S else 0.0

    def _camera_limit_mps(self, path: int, now_s: float) -> float:
        """Return the highest plausible speed of a camera track on a path (m/s)."""
        vehicle_speeds = [
            speed for last_s, speed in self._vehicle_speeds.get(path, {}).values() if now_s - last_s < MEMORY_S
        ]
        return max(vehicle_speeds) + FASTER_MPS if len(vehicle_speeds) >= MIN_VEHICLES else math.inf
