"""Separation of oriented boxes, for many pairs at once."""

from __future__ import annotations

from typing import Any

import numpy as np

from stucksolver.scene.frenet import Array

Pose = tuple[Any, Any, Any]
"""(x, y, yaw): arrays or numbers that broadcast together."""
HalfSize = tuple[Any, Any]
"""(half length, half width)."""


def separation(a: Pose, a_half: HalfSize, b: Pose, b_half: HalfSize) -> Array:
    """Largest gap between two boxes over the four axes of the separating-axis test, metres.

    Negative means that they overlap. Positive, it is exact where a face looks at the other box and a lower bound
    corner to corner, so that to demand a gap is always on the safe side.
    """
    dx, dy = np.asarray(b[0]) - a[0], np.asarray(b[1]) - a[1]
    ca, sa = np.cos(a[2]), np.sin(a[2])
    cb, sb = np.cos(b[2]), np.sin(b[2])
    # Of the angle between the two, by the addition theorems: far fewer sines than pairs.
    cos, sin = np.abs(ca * cb + sa * sb), np.abs(ca * sb - sa * cb)
    along_a = np.abs(dx * ca + dy * sa) - a_half[0] - b_half[0] * cos - b_half[1] * sin
    across_a = np.abs(dy * ca - dx * sa) - a_half[1] - b_half[0] * sin - b_half[1] * cos
    along_b = np.abs(dx * cb + dy * sb) - b_half[0] - a_half[0] * cos - a_half[1] * sin
    across_b = np.abs(dy * cb - dx * sb) - b_half[1] - a_half[0] * sin - a_half[1] * cos
    result: Array = np.maximum(np.maximum(along_a, across_a), np.maximum(along_b, across_b))
    return result
