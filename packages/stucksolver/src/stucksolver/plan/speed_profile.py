"""Computes a speed profile along a path within the limits of the path and the vehicle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver.plan.frenet_path import STEP_M, FrenetPath
from stucksolver.scene.frenet import Array
from stucksolver.scene.surroundings import VehicleLimits


@dataclass(frozen=True)
class SpeedProfile:
    """Time from now (s) and speed (m/s) at each station of a path, both (stations,)."""

    t: Array
    v: Array

    @property
    def duration_s(self) -> float:
        """Duration of the profile (s)."""
        return float(self.t[-1])


MIN_SPEED_MPS = 0.3
"""Lower bound of the profile (m/s), so that a start from rest takes a finite time. Ours."""


def rollout(path: FrenetPath, speed_mps: float, acceleration_mps2: float, braking_mps2: float) -> SpeedProfile:
    """Return the fastest profile within the bounds that starts at `speed_mps`.

    It is the classical forward and backward pass over v^2 with constant acceleration between stations. From a start
    above the bounds it brakes at the given limit.
    """
    ramp = 2 * STEP_M * np.arange(len(path.speed))
    bound = np.maximum(np.square(path.speed), MIN_SPEED_MPS**2)
    bound = np.minimum.accumulate((bound + braking_mps2 * ramp)[::-1])[::-1] - braking_mps2 * ramp
    start = max(speed_mps, MIN_SPEED_MPS) ** 2
    if start > bound[0]:
        squared = _from_above(bound.tolist(), start, acceleration_mps2, braking_mps2)
    else:
        bound[0] = start
        squared = np.minimum.accumulate(bound - acceleration_mps2 * ramp) + acceleration_mps2 * ramp
    v: Array = np.sqrt(squared)
    t: Array = np.concatenate([[0.0], np.cumsum(2 * np.diff(path.s) / (v[:-1] + v[1:]))])
    return SpeedProfile(t, v)


def _from_above(bound: list[float], start: float, acceleration_mps2: float, braking_mps2: float) -> Array:
    """Return the forward pass for a start above the bound, which it reaches by braking. Squared speeds (m²/s²)."""
    squared = [start]
    for limit in bound[1:]:
        previous = squared[-1]
        quicker = min(previous + 2 * acceleration_mps2 * STEP_M, limit)
        squared.append(max(quicker, previous - 2 * braking_mps2 * STEP_M, MIN_SPEED_MPS**2))
    return np.array(squared)


SLUGGISH_SPEED = 0.85
"""Speed of a sluggish vehicle, as a fraction of the requested one. Ours: stacks stay below a bound, not at it."""
SLUGGISH_ACCELERATION = 0.6
"""Fraction of its comfortable acceleration that a sluggish vehicle uses. Ours: loaded, uphill, or a mild controller."""


def slow_launch(
    path: FrenetPath,
    speed_mps: float,
    limits: VehicleLimits,
    speed_part: float = SLUGGISH_SPEED,
    acceleration_part: float = SLUGGISH_ACCELERATION,
) -> SpeedProfile:
    """Return the pessimistic profile: weaker acceleration, and below the requested speed throughout.

    The acceleration is the measured one of the vehicle, at most its comfortable one. Without a measurement it is
    `acceleration_part` of the comfortable one.
    """
    slower = FrenetPath(path.s, path.d, speed_part * path.speed)
    comfort, measured = limits.comfort_acceleration_mps2, limits.measured_acceleration_mps2
    acceleration = acceleration_part * comfort if measured is None else min(measured, comfort)
    return rollout(slower, speed_mps, acceleration, limits.comfort_braking_mps2)
