"""Stop signs on the route: where to stop for them, as CARLA's leaderboard judges it, and which are done."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stucksolver.scene.polyline import nearest_of_each_pass
from stucksolver_carla.drivers.behavior.path import Array

if TYPE_CHECKING:
    import carla

NEAR_M = 4.0
BOX_FACTOR = 1.2
"""A sign counts for a vehicle whose center is this near to its trigger box, on a lane that leads into that box.
The box is enlarged by this factor along the world's axes (`RunningStopTest` of CARLA's scenario_runner).
"""
_SAME_LEVEL_M = 4.0
_INSIDE_M = 0.4
"""The vehicle stops nearer than necessary by this much."""
_HALTED_MPS = 0.1
_HALT_S = 1.0
_PASSED_M = 1.0


def stop_places(signs: Sequence[carla.TrafficSign], s: Array, x: Array, y: Array, z: Array) -> list[float]:
    """Return the arc lengths at which a finely sampled line (CARLA's world, m) passes the middle of signs' trigger
    boxes.

    `signs` are actors of the type `traffic.stop`.
    """
    found = []
    for sign in signs:
        volume = sign.trigger_volume
        centre = sign.get_transform().transform(volume.location)
        away = np.hypot(x - centre.x, y - centre.y)
        inside = np.abs(x - centre.x) < BOX_FACTOR * float(volume.extent.x)
        inside &= np.abs(y - centre.y) < BOX_FACTOR * float(volume.extent.y)
        inside &= (away < NEAR_M) & (np.abs(z - centre.z) < _SAME_LEVEL_M)
        found += [float(s[k]) for k in nearest_of_each_pass(inside, away)]
    return sorted(found)


class StopSignWatch:
    """Remembers, for one route, at which signs the ego has stopped. Places are arc lengths of the route's line (m)."""

    def __init__(self, places: Sequence[float], half_length_m: float) -> None:
        self._due = list(places)
        self._half_length_m = half_length_m
        self._halted_s = 0.0

    def gap_m(self, wished_m: float) -> float:
        """Return the gap from the front bumper to the middle of the box at the stop (m), reduced so that the sign
        counts.
        """
        return min(wished_m, NEAR_M - _INSIDE_M - self._half_length_m)

    def distance_to_stop(self, front_s: float, speed_mps: float, dt_s: float) -> float | None:
        """Return the distance from the front bumper at `front_s` to the next sign's place (m); None without one."""
        while self._due and self._due[0] - front_s < self.gap_m(0.0) - _PASSED_M:
            self._due.pop(0)
        if not self._due:
            return None
        distance = self._due[0] - front_s
        halted = speed_mps < _HALTED_MPS and distance + self._half_length_m < NEAR_M - 0.1
        self._halted_s = self._halted_s + dt_s if halted else 0.0
        if self._halted_s < _HALT_S:
            return distance
        self._due.pop(0)
        self._halted_s = 0.0
        return self.distance_to_stop(front_s, speed_mps, 0.0)
