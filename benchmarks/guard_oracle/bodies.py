"""Bodies as rectangles in the plane, and when two of them touch: the oracle's own, with nothing of the guard's."""

from __future__ import annotations

import math
from dataclasses import dataclass

import shapely
from shapely.geometry import Polygon

Corners = tuple[tuple[float, float], tuple[float, float], tuple[float, float], tuple[float, float]]


@dataclass
class Body:
    """A rectangle: centre and heading in the plane (m, rad), length along the heading and width (m)."""

    x: float
    y: float
    yaw: float
    length: float
    width: float

    def corners(self) -> Corners:
        """Front left, front right, rear right, rear left, as (x, y)."""
        c, n = math.cos(self.yaw), math.sin(self.yaw)
        a, b = self.length / 2, self.width / 2
        return (
            (self.x + a * c - b * n, self.y + a * n + b * c),
            (self.x + a * c + b * n, self.y + a * n - b * c),
            (self.x - a * c + b * n, self.y - a * n - b * c),
            (self.x - a * c - b * n, self.y - a * n + b * c),
        )

    def polygon(self) -> Polygon:
        """The same as a polygon of shapely's."""
        return Polygon(self.corners())

    def within(self, other: Body, gap: float) -> bool:
        """Can two bodies be nearer to each other than a gap? Cheap, and never wrongly no."""
        reach = (math.hypot(self.length, self.width) + math.hypot(other.length, other.width)) / 2 + gap
        return (self.x - other.x) ** 2 + (self.y - other.y) ** 2 <= reach * reach


def distance(one: Body, other: Body, most: float = 5.0) -> float:
    """Gap between two bodies (m), 0 where they touch; `most` where they are further apart than that."""
    if not one.within(other, most):
        return most
    return min(float(shapely.distance(one.polygon(), other.polygon())), most)


def part_touched(body: Body, other: Body) -> str:
    """Where a body is touched: "front", "side" or "rear", by where the middle of the overlap lies on it."""
    overlap = body.polygon().intersection(other.polygon())
    if overlap.is_empty:
        return "side"
    middle = overlap.centroid
    along = (middle.x - body.x) * math.cos(body.yaw) + (middle.y - body.y) * math.sin(body.yaw)
    if along > body.length / 2 - FACE_M:
        return "front"
    return "rear" if along < -body.length / 2 + FACE_M else "side"


FACE_M = 0.25
"""So much of the body's ends counts as its front and its rear."""
