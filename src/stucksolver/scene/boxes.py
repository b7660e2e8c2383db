"""Separation of oriented boxes, for many pairs at once."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from stucksolver.scene.frenet import Array

Pose = tuple[Any, Any, Any]
"""(x, y, yaw): arrays or numbers that broadcast together."""
HalfSize = tuple[Any, Any]
"""(half length, half width)."""


Axis = tuple[Any, Any, Any]
"""(x, y) of a unit vector, and how near the middles come along it before the boxes overlap."""


class AxisGaps(NamedTuple):
    """Gaps between two boxes along the axes of the separating-axis test, metres; negative where they overlap on one."""

    along_a: Array
    across_a: Array
    along_b: Array
    across_b: Array
    cos: Array
    """Absolute cosine and sine of the angle between the two."""
    sin: Array

    @property
    def separation(self) -> Array:
        """The largest of the four; see the function of this name."""
        result: Array = np.maximum(np.maximum(self.along_a, self.across_a), np.maximum(self.along_b, self.across_b))
        return result

    def with_a_wider(self, margin_m: Any) -> AxisGaps:
        """The gaps of a box `a` that reaches farther by a margin on either side."""
        beside, along, across = self.across_a - margin_m, margin_m * self.sin, margin_m * self.cos
        return self._replace(across_a=beside, along_b=self.along_b - along, across_b=self.across_b - across)


def axis_gaps(a: Pose, a_half: HalfSize, b: Pose, b_half: HalfSize) -> AxisGaps:
    """Of two boxes, or of many pairs at once."""
    dx, dy = np.asarray(b[0]) - a[0], np.asarray(b[1]) - a[1]
    axes, cos, sin = _axes(a, a_half, b, b_half)
    along_a, across_a, along_b, across_b = (np.abs(dx * x + dy * y) - reach for x, y, reach in axes)
    return AxisGaps(along_a, across_a, along_b, across_b, cos, sin)


def _axes(a: Pose, a_half: HalfSize, b: Pose, b_half: HalfSize) -> tuple[tuple[Axis, ...], Array, Array]:
    """Along and across a, along and across b; absolute cosine and sine of the angle between them."""
    ca, sa, cb, sb = np.cos(a[2]), np.sin(a[2]), np.cos(b[2]), np.sin(b[2])
    # Of the angle between the two, by the addition theorems: far fewer sines than pairs.
    cos, sin = np.abs(ca * cb + sa * sb), np.abs(ca * sb - sa * cb)
    axes = (
        (ca, sa, a_half[0] + b_half[0] * cos + b_half[1] * sin),
        (-sa, ca, a_half[1] + b_half[0] * sin + b_half[1] * cos),
        (cb, sb, b_half[0] + a_half[0] * cos + a_half[1] * sin),
        (-sb, cb, b_half[1] + a_half[0] * sin + a_half[1] * cos),
    )
    return axes, cos, sin


def separation(a: Pose, a_half: HalfSize, b: Pose, b_half: HalfSize) -> Array:
    """Largest gap between two boxes over the four axes of the separating-axis test, metres.

    Negative means that they overlap. Positive, it is exact where a face looks at the other box and a lower bound
    corner to corner, so that to demand a gap is always on the safe side.
    """
    return axis_gaps(a, a_half, b, b_half).separation


def time_to_contact(a: Pose, a_half: HalfSize, b: Pose, b_half: HalfSize, relative_mps: tuple[Any, Any]) -> Array:
    """Seconds until two boxes touch that keep their headings, b moving past a by (x, y) `relative_mps`.

    0 where they touch already, infinity where they never do. Exact: on each axis of the separating-axis test the
    boxes overlap during one span of time, and they touch while all four spans hold.
    """
    dx, dy = np.asarray(b[0]) - a[0], np.asarray(b[1]) - a[1]
    begins: Array = np.zeros(np.shape(dx))
    ends: Array = np.full(np.shape(dx), np.inf)
    for x, y, reach in _axes(a, a_half, b, b_half)[0]:
        begin, end = _overlap_span(dx * x + dy * y, relative_mps[0] * x + relative_mps[1] * y, reach)
        begins, ends = np.maximum(begins, begin), np.minimum(ends, end)
    result: Array = np.where(begins <= ends, begins, np.inf)
    return result


def _overlap_span(distance_m: Array, speed_mps: Array, reach_m: Array) -> tuple[Array, Array]:
    """From when to when something that starts at a signed distance is within reach; empty (inf, -inf) if never."""
    standing = np.abs(speed_mps) < 1e-9
    speed = np.where(standing, 1.0, speed_mps)
    one, other = (-reach_m - distance_m) / speed, (reach_m - distance_m) / speed
    within = np.abs(distance_m) <= reach_m
    begin = np.where(standing, np.where(within, -np.inf, np.inf), np.minimum(one, other))
    end = np.where(standing, np.where(within, np.inf, -np.inf), np.maximum(one, other))
    return begin, end
