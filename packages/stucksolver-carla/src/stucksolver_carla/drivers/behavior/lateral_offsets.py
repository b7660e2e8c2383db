"""The ego's line moved aside for a while: in its lane to give room, or in the lane that it has not left yet.

Arc lengths along the route's line and offsets from it in meters, right positive.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stucksolver_carla.drivers.behavior.path import Array, Path
from stucksolver_carla.drivers.behavior.route_line import beside, slowed, smooth_step


class LateralShift(NamedTuple):
    """Out to an offset, along it, and home again."""

    offset_m: float
    begins_m: float
    beside_m: float
    """Where the offset is reached."""
    returns_m: float
    """Where the way back begins."""
    back_m: float
    """Where it ends."""

    def at(self, s: Array) -> Array:
        """Offsets at the arc lengths `s`."""
        out = smooth_step((s - self.begins_m) / max(self.beside_m - self.begins_m, 1e-6))
        home = smooth_step((s - self.returns_m) / max(self.back_m - self.returns_m, 1e-6))
        return np.asarray(self.offset_m * (out - home))


def offset_of(shifts: Sequence[LateralShift], s: Array) -> Array:
    """Return the offset of all together: on each side the farthest counts, and the two sides add up."""
    right, left = np.zeros_like(s), np.zeros_like(s)
    for shift in shifts:
        offset = shift.at(s)
        right, left = np.maximum(right, offset), np.minimum(left, offset)
    return right + left


def shifted_path(
    line: Path,
    s_m: float,
    d_m: float,
    shifts: Sequence[LateralShift],
    join_m: float,
    lateral_accel: float,
    deceleration: float,
) -> Path:
    """The rest of the route's `line` with the shifts in it, joined within `join_m` by one at `s_m`, `d_m` beside it."""
    rest = line.s >= min(s_m, line.length - 1.0)
    s = line.s[rest]
    wanted = offset_of(shifts, s)
    away = d_m - float(offset_of(shifts, np.array([s_m]))[0])
    path = beside(line, rest, wanted + away * (1.0 - smooth_step((s - s_m) / join_m)), line.speed[rest])
    return slowed(path, lateral_accel, deceleration)
