"""Gaps between oriented boxes, for many pairs at once."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from stucksolver.scene.frenet import Array

Pose = tuple[Any, Any, Any]
"""(x, y, yaw): arrays or numbers that broadcast together (m, m, rad)."""
HalfSize = tuple[Any, Any]
"""(half length, half width) (m)."""


Axis = tuple[Any, Any, Any]
"""(x, y) of a unit vector, and the distance of the box centers along it below which the boxes overlap (m)."""


class AxisGaps(NamedTuple):
    """Gaps between two boxes along the four axes of the separating-axis test (m); negative if they overlap there."""

    along_a: Array
    across_a: Array
    along_b: Array
    across_b: Array
    cos: Array
    """Absolute cosine and sine of the angle between the boxes."""
    sin: Array

    @property
    def separation(self) -> Array:
        """Largest of the four gaps (m); see the function `separation`."""
        result: Array = np.maximum(np.maximum(self.along_a, self.across_a), np.maximum(self.along_b, self.across_b))
        return result

    def with_a_wider(self, margin_m: Any) -> AxisGaps:
        """Return the gaps with box `a` widened by a margin on each side (m)."""
        across_gap, along, across = self.across_a - margin_m, margin_m * self.sin, margin_m * self.cos
        return self._replace(across_a=across_gap, along_b=self.along_b - along, across_b=self.across_b - across)


def axis_gaps(a: Pose, a_half: HalfSize, b: Pose, b_half: HalfSize) -> AxisGaps:
    """Return the gaps between two boxes, or between many pairs; poses and sizes broadcast together."""
    dx, dy = np.asarray(b[0]) - a[0], np.asarray(b[1]) - a[1]
    axes, cos, sin = separating_axes(a, a_half, b, b_half)
    along_a, across_a, along_b, across_b = (np.abs(dx * x + dy * y) - reach for x, y, reach in axes)
    return AxisGaps(along_a, across_a, along_b, across_b, cos, sin)


def separating_axes(a: Pose, a_half: HalfSize, b: Pose, b_half: HalfSize) -> tuple[tuple[Axis, ...], Array, Array]:
    """Return the axes along and across a and b, and the absolute cosine and sine of the angle between the boxes.

    Poses and sizes broadcast together; only the headings of the poses are used.
    """
    ca, sa, cb, sb = np.cos(a[2]), np.sin(a[2]), np.cos(b[2]), np.sin(b[2])
    # The addition theorems need only the sines and cosines of the headings, which are far fewer than the pairs.
    cos, sin = np.abs(ca * cb + sa * sb), np.abs(ca * sb - sa * cb)
    axes = (
        (ca, sa, a_half[0] + b_half[0] * cos + b_half[1] * sin),
        (-sa, ca, a_half[1] + b_half[0] * sin + b_half[1] * cos),
        (cb, sb, b_half[0] + a_half[0] * cos + a_half[1] * sin),
        (-sb, cb, b_half[1] + a_half[0] * sin + a_half[1] * cos),
    )
    return axes, cos, sin


def separation(a: Pose, a_half: HalfSize, b: Pose, b_half: HalfSize) -> Array:
    """Return the largest gap between two boxes over the four axes of the separating-axis test (m).

    A negative value means that the boxes overlap. A positive value is exact if a side faces the other box. From corner
    to corner it is a lower bound, so a check against a required gap errs on the safe side.
    """
    return axis_gaps(a, a_half, b, b_half).separation


def time_to_contact(a: Pose, a_half: HalfSize, b: Pose, b_half: HalfSize, relative_mps: tuple[Any, Any]) -> Array:
    """Return the time until two boxes touch (s), if both keep their headings and b moves relative to a.

    The result is exact. On each axis of the separating-axis test the boxes overlap during one time span. The boxes
    touch while all four spans hold.

    Args:
        a: Pose of box a (m, m, rad).
        a_half: Half length and half width of a (m).
        b: Pose of box b, in the same frame.
        b_half: Half length and half width of b (m).
        relative_mps: Velocity (x, y) of b relative to a (m/s).

    Returns:
        Time (s); 0 if the boxes touch now, infinity if they never touch.
    """
    dx, dy = np.asarray(b[0]) - a[0], np.asarray(b[1]) - a[1]
    begins: Array = np.zeros(np.shape(dx))
    ends: Array = np.full(np.shape(dx), np.inf)
    for x, y, reach in separating_axes(a, a_half, b, b_half)[0]:
        begin, end = _overlap_span(dx * x + dy * y, relative_mps[0] * x + relative_mps[1] * y, reach)
        begins, ends = np.maximum(begins, begin), np.minimum(ends, end)
    result: Array = np.where(begins <= ends, begins, np.inf)
    return result


def _overlap_span(distance_m: Array, speed_mps: Array, reach_m: Array) -> tuple[Array, Array]:
    """Return when a moving point enters and leaves the reach around zero (s); (inf, -inf) if it never enters."""
    standing = np.abs(speed_mps) < 1e-9
    speed = np.where(standing, 1.0, speed_mps)
    first, second = (-reach_m - distance_m) / speed, (reach_m - distance_m) / speed
    within = np.abs(distance_m) <= reach_m
    begin = np.where(standing, np.where(within, -np.inf, np.inf), np.minimum(first, second))
    end = np.where(standing, np.where(within, np.inf, -np.inf), np.maximum(first, second))
    return begin, end
