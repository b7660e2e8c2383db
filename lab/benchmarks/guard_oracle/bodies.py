"""The oracle's own rectangles and contacts in the plane. It shares no code with the guard."""

from __future__ import annotations

import math
from dataclasses import dataclass

import shapely
from shapely.geometry import Polygon

Corners = tuple[tuple[float, float], tuple[float, float], tuple[float, float], tuple[float, float]]


@dataclass
class Body:
    """A rectangle: center and heading in the plane (m, rad), length along the heading and width (m)."""

    x: float
    y: float
    yaw: float
    length: float
    width: float

    def corners(self) -> Corners:
        """Return front left, front right, rear right, rear left, as (x, y)."""
        c, n = math.cos(self.yaw), math.sin(self.yaw)
        a, b = self.length / 2, self.width / 2
        return (
            (self.x + a * c - b * n, self.y + a * n + b * c),
            (self.x + a * c + b * n, self.y + a * n - b * c),
            (self.x - a * c + b * n, self.y - a * n - b * c),
            (self.x - a * c - b * n, self.y - a * n + b * c),
        )

    def polygon(self) -> Polygon:
        """Return the rectangle as a shapely polygon."""
        return Polygon(self.corners())

    def within(self, other: Body, gap: float) -> bool:
        """True if the distance to another body may be smaller than a gap.

        The test is cheap; False is always correct.
        """
        reach = (math.hypot(self.length, self.width) + math.hypot(other.length, other.width)) / 2 + gap
        return (self.x - other.x) ** 2 + (self.y - other.y) ** 2 <= reach * reach


def distance(first: Body, second: Body, most: float = 5.0) -> float:
    """Return the gap between two bodies (m), 0 where they touch; at most `most`."""
    if not first.within(second, most):
        return most
    return min(float(shapely.distance(first.polygon(), second.polygon())), most)


def part_touched(body: Body, other: Body) -> str:
    """Return the touched part of a body: "front", "side" or "rear", from the center of the overlap."""
    overlap = body.polygon().intersection(other.polygon())
    if overlap.is_empty:
        return "side"
    middle = overlap.centroid
    along = (middle.x - body.x) * math.cos(body.yaw) + (middle.y - body.y) * math.sin(body.yaw)
    if along > body.length / 2 - FACE_M:
        return "front"
    return "rear" if along < -body.length / 2 + FACE_M else "side"


FACE_M = 0.25
"""Length of the body at each end that counts as its front or its rear (m). Ours."""
