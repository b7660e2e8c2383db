"""The Intelligent Driver Model: how hard to accelerate behind a leader.

M. Treiber, A. Hennecke, D. Helbing: "Congested traffic states in empirical observations and microscopic simulations",
Physical Review E 62 (2000).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from carlette.geometry import Floats


@dataclass(frozen=True)
class IdmParameters:
    """The model's parameters."""

    headway_s: float = 1.4
    standstill_m: float = 2.0
    acceleration_mps2: float = 1.8
    braking_mps2: float = 2.0
    """Comfortable deceleration."""
    emergency_mps2: float = 7.5
    exponent: float = 4.0


def free_acceleration(driver: IdmParameters, speed: Floats, wanted: Floats) -> Floats:
    """Return the acceleration of a car with nothing ahead (m/s²)."""
    share = speed / np.maximum(wanted, 0.1)
    free: Floats = driver.acceleration_mps2 * (1.0 - share**driver.exponent)
    return np.maximum(free, -driver.braking_mps2)


def interaction(driver: IdmParameters, speed: Floats, gap: Floats, leader: Floats) -> Floats:
    """Return how much a leader `gap` meters ahead reduces the free acceleration (m/s², zero or less)."""
    closing = speed * (speed - leader) / (2.0 * math.sqrt(driver.acceleration_mps2 * driver.braking_mps2))
    wanted = driver.standstill_m + np.maximum(0.0, speed * driver.headway_s + closing)
    loss: Floats = -driver.acceleration_mps2 * (wanted / np.maximum(gap, 0.1)) ** 2
    return loss
