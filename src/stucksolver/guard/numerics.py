"""Numbers that only the arithmetic needs: no bound of the guard depends on them."""

from __future__ import annotations

EPSILON = 1e-6
"""Two numbers that differ by less are equal, and no divisor is smaller."""
KMH_PER_MPS = 3.6
"""For numbers that people read."""


def way_to_stop(speed_mps: float, braking_mps2: float, later_s: float) -> float:
    """Return the length of a stop that begins after a delay (m): v t + v^2 / (2 b)."""
    return speed_mps**2 / (2 * braking_mps2) + speed_mps * later_s
