"""What arithmetic needs and means nothing: no bound of the guard depends on it."""

from __future__ import annotations

EPSILON = 1e-6
"""Two figures that differ by less are equal, and no divisor is smaller."""
KMH_PER_MPS = 3.6
"""For figures that people read."""


def way_to_stop(speed_mps: float, braking_mps2: float, later_s: float) -> float:
    """The way (m) of a stop that begins so much later: v t + v^2 / (2 b)."""
    return speed_mps**2 / (2 * braking_mps2) + speed_mps * later_s
