"""What arithmetic needs and means nothing: no bound of the guard depends on it."""

EPSILON = 1e-6
"""Two figures that differ by less are equal, and no divisor is smaller."""
KMH_PER_MPS = 3.6
"""For figures that people read."""
