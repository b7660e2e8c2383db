"""The report of a perfect perception: the road users in sight, and the visible length of each lane."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from lab.benchmarks.guard_oracle.bodies import Body
from lab.benchmarks.guard_oracle.others import Other
from lab.benchmarks.guard_oracle.road import Road
from stucksolver.scene import LaneSight

TALL_M = 2.0
"""Height from which on an object hides a lane from sensors on the roof (m)."""
TALLER_M = 0.3
"""Height by which an object must exceed an object behind it to hide it (m)."""
STEP_M = 3.0
"""Distance between two points of a lane whose visibility is tested (m)."""
OWN_M = 4.0
"""Distance within which objects next to the lanes hide nothing on them (m)."""


def crosses(eye: tuple[float, float], x: np.ndarray, y: np.ndarray, body: Body) -> np.ndarray:
    """Return which lines from an eye to points intersect a body."""
    c, n = math.cos(body.yaw), math.sin(body.yaw)
    ex, ey = eye[0] - body.x, eye[1] - body.y
    px, py = x - body.x, y - body.y
    ax, ay = ex * c + ey * n, ey * c - ex * n
    dx, dy = px * c + py * n - ax, py * c - px * n - ay
    with np.errstate(divide="ignore", invalid="ignore"):
        t1, t2 = (-body.length / 2 - ax) / dx, (body.length / 2 - ax) / dx
        u1, u2 = (-body.width / 2 - ay) / dy, (body.width / 2 - ay) / dy
    first = np.maximum(np.maximum(np.minimum(t1, t2), np.minimum(u1, u2)), 0.0)
    last = np.minimum(np.minimum(np.maximum(t1, t2), np.maximum(u1, u2)), 1.0)
    result: np.ndarray = first < last - 1e-9
    return result


def in_sight(eye: tuple[float, float], other: Other, hiding: Sequence[tuple[Body, float]], reach_m: float) -> bool:
    """True if any corner or the center of a road user is visible."""
    if math.hypot(other.body.x - eye[0], other.body.y - eye[1]) > reach_m:
        return False
    between = [body for body, height in hiding if body is not other.body and height >= other.height + TALLER_M]
    if not between:
        return True
    points = np.array([*other.body.corners(), (other.body.x, other.body.y)])
    hidden = np.zeros(len(points), dtype=bool)
    for body in between:
        hidden |= crosses(eye, points[:, 0], points[:, 1], body)
    return not bool(hidden.all())


def sights(
    road: Road,
    eye: tuple[float, float],
    eye_s: float,
    hiding: Sequence[tuple[Body, float]],
    ahead_m: float,
    behind_m: float,
) -> tuple[LaneSight, ...]:
    """Return the length of each lane that is visible without a gap, ahead and behind (m)."""
    tall = [body for body, height in hiding if height > TALL_M]
    found = []
    for lane in road.lanes:
        visible = []
        for way, most in ((1.0, min(ahead_m, road.end - eye_s)), (-1.0, min(behind_m, eye_s))):
            reach = max(most, 0.0)
            if tall and reach > STEP_M:
                along = np.arange(STEP_M, reach, STEP_M)
                x, y = road.points_at(eye_s + way * along, lane.offset)
                hidden = np.zeros(len(along), dtype=bool)
                for body in tall:
                    hidden |= crosses(eye, x, y, body)
                first = np.flatnonzero(hidden)
                reach = float(along[first[0]] - STEP_M) if len(first) else reach
            visible.append(reach)
        found.append(LaneSight.model_construct(lane_id=lane.name, ahead_m=visible[0], behind_m=visible[1]))
    return tuple(found)
