"""Finds the stops for stop signs on the route, as CARLA's leaderboard checks them, and tracks the completed ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stucksolver.scene.polyline import nearest_of_each_pass
from stucksolver_carla.drivers.behavior.path import Array

if TYPE_CHECKING:
    import carla

NEAR_M = 4.0
"""Maximum distance from the vehicle's center to the trigger box for a stop that counts (m).

The vehicle must be on a lane that leads into the box (`RunningStopTest` of CARLA's scenario_runner)."""
BOX_FACTOR = 1.2
"""Factor by which the box is enlarged along the world's axes (`RunningStopTest` of CARLA's scenario_runner)."""
_SAME_LEVEL_M = 4.0
"""Maximum height difference between the line and the sign's box (m). Ours."""
_INSIDE_M = 0.4
"""Distance by which the ego stops nearer than `NEAR_M` requires (m). Ours."""
_STOPPED_MPS = 0.1
"""Speed below which the ego counts as stopped (m/s). Ours."""
_STOP_S = 1.0
"""Duration of the stop (s). Ours."""
_PASSED_M = 1.0
"""Distance behind the last possible stop from which a sign counts as passed (m). Ours."""


def stop_places(signs: Sequence[carla.TrafficSign], s: Array, x: Array, y: Array, z: Array) -> list[float]:
    """Return the arc lengths at which a line passes the centers of the signs' trigger boxes (m).

    The line is finely sampled, in CARLA's world frame (m). `signs` are actors of the type `traffic.stop`.
    """
    arc_lengths = []
    for sign in signs:
        volume = sign.trigger_volume
        center = sign.get_transform().transform(volume.location)
        distance_m = np.hypot(x - center.x, y - center.y)
        is_inside = np.abs(x - center.x) < BOX_FACTOR * float(volume.extent.x)
        is_inside &= np.abs(y - center.y) < BOX_FACTOR * float(volume.extent.y)
        is_inside &= (distance_m < NEAR_M) & (np.abs(z - center.z) < _SAME_LEVEL_M)
        arc_lengths += [float(s[k]) for k in nearest_of_each_pass(is_inside, distance_m)]
    return sorted(arc_lengths)


class StopSignWatch:
    """The stop signs of one route at which the ego has not stopped yet, as arc lengths of the route's line (m)."""

    def __init__(self, arc_lengths_m: Sequence[float], half_length_m: float) -> None:
        self._due = list(arc_lengths_m)
        self._half_length_m = half_length_m
        self._stopped_s = 0.0

    def gap_m(self, wanted_m: float) -> float:
        """Return the gap from the front bumper to the box's center at a stop that counts (m), up to `wanted_m`."""
        return min(wanted_m, NEAR_M - _INSIDE_M - self._half_length_m)

    def distance_to_stop(self, front_s: float, speed_mps: float, dt_s: float) -> float | None:
        """Return the distance from the front bumper at `front_s` to the next box center (m); None without a sign."""
        while self._due and self._due[0] - front_s < self.gap_m(0.0) - _PASSED_M:
            self._due.pop(0)
        if not self._due:
            return None
        distance = self._due[0] - front_s
        is_stopped = speed_mps < _STOPPED_MPS and distance + self._half_length_m < NEAR_M - 0.1
        self._stopped_s = self._stopped_s + dt_s if is_stopped else 0.0
        if self._stopped_s < _STOP_S:
            return distance
        self._due.pop(0)
        self._stopped_s = 0.0
        return self.distance_to_stop(front_s, speed_mps, 0.0)
