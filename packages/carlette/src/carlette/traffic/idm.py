"""The Intelligent Driver Model: the acceleration behind a lead vehicle.

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
    """The model's parameters. The values are ours."""

    headway_s: float = 1.4
    """Time gap to the lead vehicle (s)."""
    standstill_m: float = 2.0
    """Gap at standstill (m)."""
    acceleration_mps2: float = 1.8
    """Largest acceleration (m/s²)."""
    braking_mps2: float = 2.0
    """Comfortable deceleration (m/s²)."""
    emergency_mps2: float = 7.5
    """Largest deceleration (m/s²)."""
    exponent: float = 4.0
    """Exponent of the free acceleration."""


def free_acceleration(driver: IdmParameters, speed: Floats, wanted: Floats) -> Floats:
    """Return the acceleration of a car with nothing ahead (m/s²)."""
    share = speed / np.maximum(wanted, 0.1)
    free: Floats = driver.acceleration_mps2 * (1.0 - share**driver.exponent)
    return np.maximum(free, -driver.braking_mps2)


def interaction(driver: IdmParameters, speed: Floats, gap: Floats, leader: Floats) -> Floats:
    """Return the reduction of the acceleration by a lead vehicle `gap` meters ahead (m/s², zero or less)."""
    closing = speed * (speed - leader) / (2.0 * math.sqrt(driver.acceleration_mps2 * driver.braking_mps2))
    wanted = driver.standstill_m + np.maximum(0.0, speed * driver.headway_s + closing)
    loss: Floats = -driver.acceleration_mps2 * (wanted / np.maximum(gap, 0.1)) ** 2
    return loss
