"""Numerical constants and formulas. No bound of the guard depends on the constants."""

from __future__ import annotations

EPSILON = 1e-6
"""Difference below which numbers count as equal, and lower bound for divisors."""
KMH_PER_MPS = 3.6
"""Conversion for numbers in texts for people."""


def stopping_distance_m(speed_mps: float, braking_mps2: float, later_s: float) -> float:
    """Return the stopping distance if braking begins after a delay (m): v t + v^2 / (2 b)."""
    return speed_mps**2 / (2 * braking_mps2) + speed_mps * later_s
