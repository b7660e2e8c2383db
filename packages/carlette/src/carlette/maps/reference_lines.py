"""Reference lines made of straight pieces and arcs, in the map's right-handed frame (meters, radians)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

_STRAIGHT_RAD = 1e-9
"""Change of heading below which a segment is straight (rad)."""
_SHORTEST_M = 1e-6
"""Shortest segment (m)."""


@dataclass(frozen=True)
class Segment:
    """A piece of constant curvature (1/m, positive to the left; 0 is a straight line)."""

    length_m: float
    curvature: float = 0.0


@dataclass(frozen=True)
class Pose2D:
    """A point with a heading, counterclockwise from the x axis."""

    x: float
    y: float
    yaw_rad: float

    def moved(self, ahead_m: float, left_m: float = 0.0) -> Pose2D:
        """Return the pose at an offset from this one, with the same heading."""
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return Pose2D(self.x + ahead_m * cos - left_m * sin, self.y + ahead_m * sin + left_m * cos, self.yaw_rad)

    def reversed(self) -> Pose2D:
        """Return the same point in the opposite direction."""
        return Pose2D(self.x, self.y, self.yaw_rad + math.pi)

    def after(self, segment: Segment) -> Pose2D:
        """Return the end of a segment that starts here."""
        turn_rad = segment.length_m * segment.curvature
        if segment.curvature == 0.0:
            return self.moved(segment.length_m)
        radius_m = 1.0 / segment.curvature
        end = self.moved(radius_m * math.sin(turn_rad), radius_m * (1.0 - math.cos(turn_rad)))
        return Pose2D(end.x, end.y, self.yaw_rad + turn_rad)


def end_of(start: Pose2D, segments: Iterable[Segment]) -> Pose2D:
    """Return the end of a chain of segments that starts at `start`."""
    for segment in segments:
        start = start.after(segment)
    return start


def arc(radius_m: float, turn_rad: float) -> Segment:
    """Return a bend of this radius; a positive turn is to the left."""
    return Segment(radius_m * abs(turn_rad), math.copysign(1.0 / radius_m, turn_rad))


def connect(start: Pose2D, end: Pose2D) -> list[Segment]:
    """Return the line, arc and line that lead from one pose to another without a kink.

    Raises `ValueError` if no such line exists: the poses are parallel but not in line, or face away.
    """
    turn_rad = math.remainder(end.yaw_rad - start.yaw_rad, 2 * math.pi)
    dx, dy = end.x - start.x, end.y - start.y
    ahead_m = dx * math.cos(start.yaw_rad) + dy * math.sin(start.yaw_rad)
    left_m = dy * math.cos(start.yaw_rad) - dx * math.sin(start.yaw_rad)
    if abs(turn_rad) < _STRAIGHT_RAD:
        if abs(left_m) > 1e-6 or ahead_m <= 0:
            raise ValueError(f"no straight line leads from {start} to {end}")
        return [Segment(ahead_m)]
    to_end_m = left_m / math.sin(turn_rad)
    to_corner_m = ahead_m - to_end_m * math.cos(turn_rad)
    tangent_m = min(to_corner_m, to_end_m)
    if tangent_m <= 0:
        raise ValueError(f"no single arc leads from {start} to {end}")
    bend = arc(tangent_m / math.tan(abs(turn_rad) / 2), turn_rad)
    straights = (Segment(to_corner_m - tangent_m), bend, Segment(to_end_m - tangent_m))
    return [piece for piece in straights if piece.length_m > 1e-6]


def lead(start: Pose2D, end: Pose2D) -> list[Segment]:
    """Return a smooth line from one pose to another: `connect` if that is possible, else two arcs."""
    try:
        return connect(start, end)
    except ValueError:
        # No single arc connects the poses.
        return two_arcs(start, end)


def two_arcs(start: Pose2D, end: Pose2D) -> list[Segment]:
    """Return two arcs that meet without a kink (a biarc with equal tangent lengths).

    Raises `ValueError` if the poses coincide, the end is straight behind the start, or one arc would be a point.
    """
    dx, dy = end.x - start.x, end.y - start.y
    cos0, sin0, cos1, sin1 = (f(a) for a in (start.yaw_rad, end.yaw_rad) for f in (math.cos, math.sin))
    along = dx * (cos0 + cos1) + dy * (sin0 + sin1)
    bend = 2.0 * (1.0 - cos0 * cos1 - sin0 * sin1)
    square = dx * dx + dy * dy
    if bend < _STRAIGHT_RAD:
        tangent_m = square / (2.0 * along) if along > 0 else 0.0
    else:
        tangent_m = (math.sqrt(along * along + bend * square) - along) / bend
    if tangent_m <= 0:
        raise ValueError(f"no pair of arcs leads from {start} to {end}")
    middle_x = (start.x + end.x + tangent_m * (cos0 - cos1)) / 2
    middle_y = (start.y + end.y + tangent_m * (sin0 - sin1)) / 2
    first = _arc_to(start, middle_x, middle_y)
    second = _arc_to(start.after(first), end.x, end.y)
    return [first, second]


def _arc_to(start: Pose2D, x: float, y: float) -> Segment:
    """Return the arc (or line) that leaves `start` along its heading and ends in a point."""
    dx, dy = x - start.x, y - start.y
    ahead_m = dx * math.cos(start.yaw_rad) + dy * math.sin(start.yaw_rad)
    left_m = dy * math.cos(start.yaw_rad) - dx * math.sin(start.yaw_rad)
    chord_m = math.hypot(dx, dy)
    if chord_m < _SHORTEST_M:
        raise ValueError(f"an arc from {start} to ({x:.3f}, {y:.3f}) would be a point")
    if abs(left_m) < 1e-7 * chord_m:
        return Segment(chord_m)
    turn_rad = 2.0 * math.atan2(left_m, ahead_m)
    return arc(abs(chord_m / (2.0 * math.sin(turn_rad / 2.0))), turn_rad)
