"""Converts the objects around the ego to the route's frame: position and speed along the route and across it.

Arc lengths along the route's line and offsets from it are in meters, right positive.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import SPACING_M, Array, Path

BEHIND_M = 80.0
"""Length of the line behind the ego (m). Ours."""
AHEAD_M = 220.0
"""Length of the line ahead of the ego (m). Ours."""
_STRIDE = round(1.0 / SPACING_M)
"""Number of samples per meter of the line."""
_BELOW_M = 1.0
"""Objects that end this far below the line are on another level (m). Ours."""
_ABOVE_M = 2.3
"""Objects that start this far above the line are on another level (m). Ours."""

Flags = np.ndarray[Any, np.dtype[np.bool_]]


@dataclass(frozen=True, eq=False)
class RouteObjects:
    """Boxes along a route; arrays of equal length."""

    actor_id: np.ndarray[Any, np.dtype[np.int64]]
    is_walker: Flags
    s: Array
    d: Array
    along: Array
    """Half of the length along the route (m)."""
    aside: Array
    """Half of the width across the route (m)."""
    vs: Array
    vd: Array

    def __len__(self) -> int:
        return len(self.actor_id)

    @property
    def speed(self) -> Array:
        """Speed (m/s)."""
        return np.asarray(np.hypot(self.vs, self.vd))

    def has_id_in(self, ids: frozenset[int]) -> Flags:
        """Return True for the objects with one of these ids."""
        return np.isin(self.actor_id, list(ids))

    def part(self, selected: Flags) -> RouteObjects:
        """Return the selected objects."""
        return RouteObjects(*(getattr(self, name)[selected] for name in self.__dataclass_fields__))


def objects_on_route(line: Path, s_m: float, around: NearbyObjects) -> RouteObjects:
    """Return the objects on the level of a route's `line`, between `BEHIND_M` and `AHEAD_M` of its arc length `s_m`."""
    low = int(np.searchsorted(line.s, s_m - BEHIND_M))
    high = max(int(np.searchsorted(line.s, s_m + AHEAD_M)), low + 2)
    samples = slice(low, high, _STRIDE)
    xs, ys, yaws, arc_lengths, zs = (
        line.x[samples],
        line.y[samples],
        line.yaw[samples],
        line.s[samples],
        line.z[samples],
    )
    dx, dy = around.x[:, None] - xs, around.y[:, None] - ys
    nearest = np.argmin(dx * dx + dy * dy, axis=1) if len(around) else np.zeros(0, np.int64)
    rows = np.arange(len(around))
    cos, sin = np.cos(yaws[nearest]), np.sin(yaws[nearest])
    dx, dy = dx[rows, nearest], dy[rows, nearest]
    turn = around.yaw - yaws[nearest]
    across, ahead = np.abs(np.sin(turn)), np.abs(np.cos(turn))
    objects = RouteObjects(
        np.array(around.actor_id, dtype=np.int64),
        around.is_walker,
        arc_lengths[nearest] + dx * cos + dy * sin,
        dy * cos - dx * sin,
        ahead * around.half_length + across * around.half_width,
        across * around.half_length + ahead * around.half_width,
        around.vx * cos + around.vy * sin,
        around.vy * cos - around.vx * sin,
    )
    z = zs[nearest]
    return objects.part(np.asarray((around.top > z - _BELOW_M) & (around.bottom < z + _ABOVE_M)))
