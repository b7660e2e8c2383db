"""The speed of a vehicle that sensors have just found: about the pace of those who drove there before.

At the edge of the LiDAR's grid, speeds are measured too low at first: 10 to 14 m/s of 20. Whoever sets off before such
a vehicle because it seems slow gets in its way. The camera alone gives a bound, up to twice the speed: whoever believes
that lets gaps go by.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath
from stucksolver_carla.drivers.behavior.conflicting_traffic import ConflictingVehicle
from stucksolver_carla.drivers.behavior.nearby_objects import FIRST_FAR_ID

NEW_S = 0.7
"""A vehicle is new for so long after it was first seen on a way (s)."""
PACE_S = 5.0
"""The pace of a way is forgotten when nobody has driven there for so long (s)."""
FASTER_MPS = 2.0
"""Whom only the camera sees is faster by no more than this (m/s) than the fastest ..."""
KNOWN = 2
"""... of at least so many others ..."""
KNOWN_S = 12.0
"""... who drove there within this time (s)."""


class LaneSpeedPrior:
    """Remembers how fast vehicles drove on the ways of one junction."""

    def __init__(self) -> None:
        self._since: dict[tuple[int, int], float] = {}
        self._paces: dict[int, tuple[float, float]] = {}
        """By way: when somebody last drove there (s), and the median speed then (m/s)."""
        self._drove: dict[int, dict[int, tuple[float, float]]] = {}
        """By way and vehicle: when it last drove there (s), and its highest speed (m/s)."""

    def of(
        self, seen: Sequence[tuple[ConflictPath, ConflictingVehicle]], now_s: float
    ) -> list[tuple[ConflictPath, ConflictingVehicle]]:
        """Return them, the new ones with the pace of their way (m/s) if they seem slower, those that only the camera
        sees with little more than others drove if they seem faster.
        """
        self._since = {(id(way), item.actor_id): self._since.get((id(way), item.actor_id), now_s) for way, item in seen}
        speeds: dict[int, list[float]] = {}
        for way, item in seen:
            if item.actor_id < FIRST_FAR_ID and not self._is_new(way, item, now_s):
                speeds.setdefault(id(way), []).append(item.speed)
                drove = self._drove.setdefault(id(way), {})
                drove[item.actor_id] = now_s, max(item.speed, drove.get(item.actor_id, (0.0, 0.0))[1])
        self._paces |= {way: (now_s, float(np.median(some))) for way, some in speeds.items()}
        return [(way, self._believed(way, item, now_s)) for way, item in seen]

    def _is_new(self, way: ConflictPath, vehicle: ConflictingVehicle, now_s: float) -> bool:
        return now_s - self._since[id(way), vehicle.actor_id] < NEW_S

    def _believed(self, way: ConflictPath, vehicle: ConflictingVehicle, now_s: float) -> ConflictingVehicle:
        speed = max(vehicle.speed, self._pace(id(way), now_s)) if self._is_new(way, vehicle, now_s) else vehicle.speed
        most = self._most(id(way), now_s) if vehicle.actor_id >= FIRST_FAR_ID else math.inf
        return vehicle._replace(speed=min(speed, most))

    def _pace(self, way: int, now_s: float) -> float:
        since_s, pace = self._paces.get(way, (now_s, 0.0))
        return pace if now_s - since_s < PACE_S else 0.0

    def _most(self, way: int, now_s: float) -> float:
        """Return the highest speed of whom only the camera sees there (m/s)."""
        drove = [speed for last_s, speed in self._drove.get(way, {}).values() if now_s - last_s < KNOWN_S]
        return max(drove) + FASTER_MPS if len(drove) >= KNOWN else math.inf
