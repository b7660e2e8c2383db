"""Bodies around the ego in the route's frame: position and speed along it and across it.

Arc lengths in meters along the route's line, offsets in meters from it, right positive.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import SPACING_M, Array, Path

BEHIND_M = 80.0
AHEAD_M = 220.0
_STRIDE = round(1.0 / SPACING_M)
_BELOW_M = 1.0
_ABOVE_M = 2.3

Flags = np.ndarray[Any, np.dtype[np.bool_]]


@dataclass(frozen=True, eq=False)
class RouteObjects:
    """Boxes along a route; arrays of equal length."""

    actor_id: np.ndarray[Any, np.dtype[np.int64]]
    is_walker: Flags
    s: Array
    d: Array
    along: Array
    """Half of the length that each occupies along the route."""
    aside: Array
    """Half of the width that each occupies across it."""
    vs: Array
    vd: Array

    def __len__(self) -> int:
        return len(self.actor_id)

    @property
    def speed(self) -> Array:
        """m/s."""
        return np.asarray(np.hypot(self.vs, self.vd))

    def among(self, ids: frozenset[int]) -> Flags:
        """True for those with one of these ids."""
        return np.isin(self.actor_id, list(ids))

    def part(self, which: Flags) -> RouteObjects:
        """Return some of them."""
        return RouteObjects(*(getattr(self, name)[which] for name in self.__dataclass_fields__))


def on_route(line: Path, s_m: float, around: NearbyObjects) -> RouteObjects:
    """Return the bodies `around` that are not above or below a route's `line`, seen from its arc length `s_m`."""
    low = int(np.searchsorted(line.s, s_m - BEHIND_M))
    high = max(int(np.searchsorted(line.s, s_m + AHEAD_M)), low + 2)
    pick = slice(low, high, _STRIDE)
    xs, ys, yaws, places, zs = line.x[pick], line.y[pick], line.yaw[pick], line.s[pick], line.z[pick]
    dx, dy = around.x[:, None] - xs, around.y[:, None] - ys
    nearest = np.argmin(dx * dx + dy * dy, axis=1) if len(around) else np.zeros(0, np.int64)
    rows = np.arange(len(around))
    cos, sin = np.cos(yaws[nearest]), np.sin(yaws[nearest])
    dx, dy = dx[rows, nearest], dy[rows, nearest]
    turn = around.yaw - yaws[nearest]
    across, ahead = np.abs(np.sin(turn)), np.abs(np.cos(turn))
    found = RouteObjects(
        np.array(around.actor_id, dtype=np.int64),
        around.is_walker,
        places[nearest] + dx * cos + dy * sin,
        dy * cos - dx * sin,
        ahead * around.half_length + across * around.half_width,
        across * around.half_length + ahead * around.half_width,
        around.vx * cos + around.vy * sin,
        around.vy * cos - around.vx * sin,
    )
    z = zs[nearest]
    return found.part(np.asarray((around.top > z - _BELOW_M) & (around.bottom < z + _ABOVE_M)))
