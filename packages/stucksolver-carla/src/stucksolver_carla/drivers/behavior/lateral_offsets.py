"""Shifts the ego's line laterally for a while: inside its lane, or into the lane that it has not left yet.

Arc lengths along the route's line and offsets from it are in meters, right positive.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stucksolver_carla.drivers.behavior.path import Array, Path
from stucksolver_carla.drivers.behavior.route_line import offset_path, smooth_step, speed_limited_path


class LateralShift(NamedTuple):
    """A shift to an offset and back to the route's line."""

    offset_m: float
    begins_m: float
    """Arc length at which the shift starts (m)."""
    beside_m: float
    """Arc length at which the offset is reached (m)."""
    returns_m: float
    """Arc length at which the return starts (m)."""
    back_m: float
    """Arc length at which the return ends (m)."""

    def at(self, s: Array) -> Array:
        """Return the offsets at the arc lengths `s` (m)."""
        share_out = smooth_step((s - self.begins_m) / max(self.beside_m - self.begins_m, 1e-6))
        share_back = smooth_step((s - self.returns_m) / max(self.back_m - self.returns_m, 1e-6))
        return np.asarray(self.offset_m * (share_out - share_back))


def offset_of(shifts: Sequence[LateralShift], s: Array) -> Array:
    """Return the common offset of several shifts (m): the farthest on each side, and the sum of both sides."""
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
    """Return the rest of the route's `line` with the shifts, joined within `join_m` by an ego at `s_m` and `d_m`."""
    rest = line.s >= min(s_m, line.length - 1.0)
    s = line.s[rest]
    offsets = offset_of(shifts, s)
    deviation_m = d_m - float(offset_of(shifts, np.array([s_m]))[0])
    path = offset_path(line, rest, offsets + deviation_m * (1.0 - smooth_step((s - s_m) / join_m)), line.speed[rest])
    return speed_limited_path(path, lateral_accel, deceleration)
