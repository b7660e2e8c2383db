"""Left turns driven squarely: straight on into the junction, then round a tight arc.

The lanes of a wide junction turn on a wide arc. On it the ego meets oncoming cars almost head-on and is in their lane
for a long way; on a tight one it crosses their lanes steeply, so that a shorter gap between two cars is enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath, JunctionConflicts
from stucksolver_carla.drivers.behavior.path import Array, Path, make_path

RADIUS_M = 7.0
"""Radius of the tight arc: passenger cars turn on 5.5 to 6 m at full lock."""
_STRAIGHT_PER_M = 0.01
"""Curvature below which the line counts as straight (1/m): a tenth of that of a town's bends."""
_BESIDE_BEND_M = 1.0
_BEFORE_M = 3.0
"""The bend of a turn is looked for from so far before the junction on (m)."""
_LEAST_TURN_RAD = math.radians(60.0)
_MOST_TURN_RAD = math.radians(120.0)
_SHARES = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5)
"""Shares of the turn, tried in this order, after which the square line joins the lanes' own arc: where a road ends at
the junction, nothing is paved beyond that arc.
"""
_OPPOSED_COS = math.cos(math.radians(150.0))
_ARC_STEP_M = 0.5
_CHECKED_EVERY = 4
"""Every so many samples of the line, a meter apart, it is checked that the body stays on the road."""

Drivable = Callable[[float, float, float], bool]
"""True if a place of CARLA's world frame (x, y, z in meters) is on a driving lane."""


class SquareTurn(NamedTuple):
    """A route's line with one turn made square."""

    line: Path
    first_m: float
    """Where it leaves the old line (m)."""
    last_m: float
    """Where it joins the old line again, in meters of the old line."""
    longer_m: float
    """By how much it is longer (m)."""

    def moved(self, s: Array) -> Array:
        """Return where arc lengths of the old line lie on the new one."""
        end = float(max(s.max(initial=0.0), self.last_m + 1.0))
        places = np.array([0.0, self.first_m, self.last_m, end])
        return np.asarray(np.interp(s, places, places + self.longer_m * np.array([0.0, 0.0, 1.0, 1.0])))


def stream_ways(line: Path, meeting: JunctionConflicts) -> list[ConflictPath]:
    """Return the ways of a junction by which oncoming traffic with the right of way goes straight across the route."""
    own = float(line.at(np.array([meeting.wait_s - 1.0]))[2][0])
    found = []
    for way in meeting.ways:
        yaw = float(np.interp(way.inside_s, way.s, way.yaw))
        if way.goes_first and way.straight and not way.joins and math.cos(yaw - own) < _OPPOSED_COS:
            found.append(way)
    return found


def with_square_turn(
    line: Path, meeting: JunctionConflicts, half_width: float, drivable: Drivable
) -> SquareTurn | None:
    """Return the route's `line` with its left turn at a junction made square.

    None if it does not turn left there, if the lanes' own arc is as tight, or if the body, `half_width` meters to
    either side, would leave the driving lanes.
    """
    bends = line.curvature < -_STRAIGHT_PER_M
    begins = np.flatnonzero(bends & (line.s > meeting.wait_s - _BEFORE_M) & (line.s < meeting.last_s))
    if len(begins) == 0:
        return None
    ends = np.flatnonzero(~bends & (line.s > line.s[begins[0]]))
    last = float(line.s[ends[0]]) + _BESIDE_BEND_M if len(ends) else line.length
    first, last = max(float(line.s[begins[0]]) - _BESIDE_BEND_M, 0.0), min(last, line.length)
    turned = np.abs(line.yaw - line.at(np.array([first]))[2][0])
    whole = float(np.interp(last, line.s, turned))
    if not _LEAST_TURN_RAD < whole < _MOST_TURN_RAD:
        return None
    bend = (line.s >= first) & (line.s <= last)
    for share in _SHARES:
        joins = last if share == 1.0 else float(line.s[bend][int(np.argmax(turned[bend] >= share * whole))])
        turn = _squared_between(line, first, joins)
        if turn is not None and _is_on_lanes(turn, half_width, drivable):
            return turn
    return None


def _squared_between(line: Path, first: float, last: float) -> SquareTurn | None:
    arc = _corner(line, first, last)
    if arc is None:
        return None
    path = _with(line, first, last, *arc)
    return SquareTurn(path, first, last, path.length - line.length)


def _corner(line: Path, first: float, last: float) -> tuple[Array, Array] | None:
    """Return the places of a tight arc between the straight lines along the route at two places."""
    (x0, x1), (y0, y1), (yaw0, yaw1) = line.at(np.array([first, last]))
    turned = abs(yaw1 - yaw0)
    # Where the two straight lines meet, measured from either end.
    dx, dy = x1 - x0, y1 - y0
    before = (dx * math.sin(yaw1) - dy * math.cos(yaw1)) / math.sin(yaw1 - yaw0)
    behind = (dy * math.cos(yaw0) - dx * math.sin(yaw0)) / math.sin(yaw1 - yaw0)
    tangent = RADIUS_M * math.tan(turned / 2.0)
    if min(before, behind) <= tangent:
        return None
    angle = np.linspace(0.0, turned, max(round(RADIUS_M * turned / _ARC_STEP_M), 2))
    along, left = before - tangent + RADIUS_M * np.sin(angle), RADIUS_M * (1.0 - np.cos(angle))
    x = x0 + along * math.cos(yaw0) + left * math.sin(yaw0)
    y = y0 + along * math.sin(yaw0) - left * math.cos(yaw0)
    return x, y


def _with(line: Path, first: float, last: float, x: Array, y: Array) -> Path:
    """Return the line with other places between two arc lengths, without bounds on speed."""
    head, tail = line.s <= first, line.s >= last
    z = np.interp(np.linspace(first, last, len(x)), line.s, line.z)
    fastest = float(line.speed.max())
    xs, ys = np.concatenate([line.x[head], x, line.x[tail]]), np.concatenate([line.y[head], y, line.y[tail]])
    return make_path(xs, ys, np.full(len(xs), fastest), np.concatenate([line.z[head], z, line.z[tail]]))


def _is_on_lanes(turn: SquareTurn, half_width: float, drivable: Drivable) -> bool:
    path, first, last = turn.line, turn.first_m, turn.last_m + turn.longer_m
    pick = np.flatnonzero((path.s >= first) & (path.s <= last))[::_CHECKED_EVERY]
    sides = np.array([-half_width, 0.0, half_width])[:, None]
    x = path.x[pick] - sides * np.sin(path.yaw[pick])
    y = path.y[pick] + sides * np.cos(path.yaw[pick])
    places = np.stack([x, y, np.broadcast_to(path.z[pick], x.shape)], axis=-1).reshape(-1, 3)
    return all(drivable(*place) for place in places.tolist())
