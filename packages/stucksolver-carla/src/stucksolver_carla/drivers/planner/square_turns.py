"""Replaces the wide arc of a turn across the oncoming lanes by a square turn: straight on, then a tight arc.

It is a left turn in right-hand traffic, and a right turn in left-hand traffic.

The lanes of a wide junction turn on a wide arc. On it the ego meets oncoming cars almost head-on, and is in their lane
for a long distance. On a tight arc it crosses their lanes steeply, so a shorter gap suffices.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath, JunctionConflicts
from stucksolver_carla.drivers.behavior.path import Array, Path, make_path

RADIUS_M = 7.0
"""Radius of the tight arc (m): passenger cars turn on 5.5 to 6 m at full lock."""
_STRAIGHT_PER_M = 0.01
"""Curvature below which the line counts as straight (1/m): a tenth of that of a town's bends."""
_BEND_MARGIN_M = 1.0
"""Length of the line before and after the bend that is replaced too (m). Ours."""
_BEFORE_M = 3.0
"""Distance before the junction from which the bend is searched (m). Ours."""
_MIN_TURN_RAD = math.radians(60.0)
"""Minimum heading change of a turn that is made square (rad). Ours."""
_MAX_TURN_RAD = math.radians(120.0)
"""Maximum heading change of a turn that is made square (rad). Ours."""
_SHARES = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5)
"""Shares of the turn after which the square line joins the lanes' arc, tried in this order. Where a road ends at the
junction, the surface ends at that arc. Ours."""
_OPPOSITE_COS = math.cos(math.radians(150.0))
"""Cosine of the angle from which traffic is oncoming. Ours."""
_ARC_STEP_M = 0.5
"""Distance between two points of the arc (m). Ours."""
_CHECK_STRIDE = 4
"""Number of samples, one meter, between two checks that the ego's box is on the road."""

Drivable = Callable[[float, float, float], bool]
"""Returns True if a point of CARLA's world frame (x, y, z in m) is on a driving lane."""


class SquareTurn(NamedTuple):
    """A route's line with one square turn."""

    line: Path
    first_m: float
    """Arc length at which the new line leaves the old one (m)."""
    last_m: float
    """Arc length of the old line at which the new one joins it (m)."""
    longer_m: float
    """Additional length of the new line (m)."""

    def arc_lengths_on_new(self, s: Array) -> Array:
        """Return the arc lengths on the new line for arc lengths of the old one (m)."""
        end = float(max(s.max(initial=0.0), self.last_m + 1.0))
        knots = np.array([0.0, self.first_m, self.last_m, end])
        return np.asarray(np.interp(s, knots, knots + self.longer_m * np.array([0.0, 0.0, 1.0, 1.0])))


def oncoming_paths(line: Path, junction: JunctionConflicts) -> list[ConflictPath]:
    """Return the paths of oncoming through traffic with the right of way that cross the route at a junction."""
    own_yaw = float(line.at(np.array([junction.wait_s - 1.0]))[2][0])
    paths = []
    for path in junction.ways:
        yaw = float(np.interp(path.inside_s, path.s, path.yaw))
        if path.goes_first and path.straight and not path.joins and math.cos(yaw - own_yaw) < _OPPOSITE_COS:
            paths.append(path)
    return paths


def with_square_turn(
    line: Path, junction: JunctionConflicts, half_width: float, drivable: Drivable, edge_side: float = 1.0
) -> SquareTurn | None:
    """Return the route's `line` with a square turn at a junction; None if that is not possible.

    It is not possible if the line does not turn away from the road's edge there (`edge_side`: 1 right, -1 left), if the
    lanes' arc is as tight, or if the ego's box, which extends `half_width` meters to either side, would leave the
    driving lanes.
    """
    bends = edge_side * line.curvature < -_STRAIGHT_PER_M
    begin_indices = np.flatnonzero(bends & (line.s > junction.wait_s - _BEFORE_M) & (line.s < junction.last_s))
    if len(begin_indices) == 0:
        return None
    end_indices = np.flatnonzero(~bends & (line.s > line.s[begin_indices[0]]))
    last = float(line.s[end_indices[0]]) + _BEND_MARGIN_M if len(end_indices) else line.length
    first, last = max(float(line.s[begin_indices[0]]) - _BEND_MARGIN_M, 0.0), min(last, line.length)
    turn_rad = np.abs(line.yaw - line.at(np.array([first]))[2][0])
    total_rad = float(np.interp(last, line.s, turn_rad))
    if not _MIN_TURN_RAD < total_rad < _MAX_TURN_RAD:
        return None
    bend = (line.s >= first) & (line.s <= last)
    for share in _SHARES:
        joins_at = last if share == 1.0 else float(line.s[bend][int(np.argmax(turn_rad[bend] >= share * total_rad))])
        turn = _squared_between(line, first, joins_at, edge_side)
        if turn is not None and _is_on_lanes(turn, half_width, drivable):
            return turn
    return None


def _squared_between(line: Path, first: float, last: float, edge_side: float) -> SquareTurn | None:
    arc = _corner(line, first, last, edge_side)
    if arc is None:
        return None
    path = _with_points(line, first, last, *arc)
    return SquareTurn(path, first, last, path.length - line.length)


def _corner(line: Path, first: float, last: float, edge_side: float) -> tuple[Array, Array] | None:
    """Return the points of a tight arc between two tangents of the route; None if it does not fit."""
    (x0, x1), (y0, y1), (yaw0, yaw1) = line.at(np.array([first, last]))
    turn_rad = abs(yaw1 - yaw0)
    # The distances from both ends to the intersection of the tangents.
    dx, dy = x1 - x0, y1 - y0
    before_m = (dx * math.sin(yaw1) - dy * math.cos(yaw1)) / math.sin(yaw1 - yaw0)
    behind_m = (dy * math.cos(yaw0) - dx * math.sin(yaw0)) / math.sin(yaw1 - yaw0)
    tangent = RADIUS_M * math.tan(turn_rad / 2.0)
    if min(before_m, behind_m) <= tangent:
        return None
    angle = np.linspace(0.0, turn_rad, max(round(RADIUS_M * turn_rad / _ARC_STEP_M), 2))
    along_m, left_m = before_m - tangent + RADIUS_M * np.sin(angle), edge_side * RADIUS_M * (1.0 - np.cos(angle))
    x = x0 + along_m * math.cos(yaw0) + left_m * math.sin(yaw0)
    y = y0 + along_m * math.sin(yaw0) - left_m * math.cos(yaw0)
    return x, y


def _with_points(line: Path, first: float, last: float, x: Array, y: Array) -> Path:
    """Return the line with other points between two arc lengths, without speed bounds."""
    head, tail = line.s <= first, line.s >= last
    z = np.interp(np.linspace(first, last, len(x)), line.s, line.z)
    fastest = float(line.speed.max())
    xs, ys = np.concatenate([line.x[head], x, line.x[tail]]), np.concatenate([line.y[head], y, line.y[tail]])
    return make_path(xs, ys, np.full(len(xs), fastest), np.concatenate([line.z[head], z, line.z[tail]]))


def _is_on_lanes(turn: SquareTurn, half_width: float, drivable: Drivable) -> bool:
    path, first, last = turn.line, turn.first_m, turn.last_m + turn.longer_m
    samples = np.flatnonzero((path.s >= first) & (path.s <= last))[::_CHECK_STRIDE]
    sides = np.array([-half_width, 0.0, half_width])[:, None]
    x = path.x[samples] - sides * np.sin(path.yaw[samples])
    y = path.y[samples] + sides * np.cos(path.yaw[samples])
    knots = np.stack([x, y, np.broadcast_to(path.z[samples], x.shape)], axis=-1).reshape(-1, 3)
    return all(drivable(*point) for point in knots.tolist())
