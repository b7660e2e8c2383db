"""When the ego is where on a path: a speed profile within the path's bounds and the vehicle's limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver.decision.manoeuvre import STEP_M, Manoeuvre
from stucksolver.scene.frenet import Array
from stucksolver.scene.surroundings import VehicleLimits


@dataclass(frozen=True)
class Rollout:
    """Time since now (s) and speed (m/s) at each station of a path."""

    t: Array
    v: Array

    @property
    def duration_s(self) -> float:
        return float(self.t[-1])


MIN_SPEED_MPS = 0.3
"""Floor of the profile, so that standing still at the start takes a finite time."""


def rollout(path: Manoeuvre, speed_mps: float, acceleration_mps2: float, braking_mps2: float) -> Rollout:
    """The quickest profile under the bounds that starts at `speed_mps`.

    The classical forward and backward pass over v^2 with constant acceleration between stations. A start above the
    bounds brakes as hard as it is allowed to.
    """
    bound = np.square(path.speed).tolist()
    for i in range(len(bound) - 2, -1, -1):
        bound[i] = min(bound[i], bound[i + 1] + 2 * braking_mps2 * STEP_M)
    squared = [max(speed_mps, MIN_SPEED_MPS) ** 2]
    for limit in bound[1:]:
        previous = squared[-1]
        quicker = min(previous + 2 * acceleration_mps2 * STEP_M, limit)
        squared.append(max(quicker, previous - 2 * braking_mps2 * STEP_M, MIN_SPEED_MPS**2))
    v: Array = np.sqrt(np.array(squared))
    ds = np.diff(path.s)
    t: Array = np.concatenate([[0.0], np.cumsum(2 * ds / (v[:-1] + v[1:]))])
    return Rollout(t, v)


def sluggish(path: Manoeuvre, speed_mps: float, limits: VehicleLimits) -> Rollout:
    """The pessimistic hypothesis: weaker acceleration, and never quite the speed that was asked for."""
    slower = Manoeuvre(path.s, path.d, 0.85 * path.speed)
    return rollout(slower, speed_mps, 0.6 * limits.comfort_acceleration_mps2, limits.comfort_braking_mps2)
