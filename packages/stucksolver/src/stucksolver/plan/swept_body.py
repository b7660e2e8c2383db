"""Where a body that follows its axle has room: offsets blocked by objects, and offsets within the road's borders.

The axle without steering rolls where the body points, so an offset and a heading of this axle fix the whole body.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stucksolver.scene.boxes import HalfSize, Pose, separating_axes, separation
from stucksolver.scene.frenet import Array, Mask
from stucksolver.scene.frenet_scene import FrenetScene

PARALLEL = 1e-9
"""Smallest component of an axis across the road: below it the offset does not matter on this axis."""


@dataclass(frozen=True)
class Body:
    """Box of the ego around its axle without steering.

    Attributes:
        half_length_m, half_width_m: Half sizes of the box (m).
        lever_m: Distance of the box center ahead of the axle (m); negative in reverse, when the axle leads.
    """

    half_length_m: float
    half_width_m: float
    lever_m: float

    @classmethod
    def of(cls, view: FrenetScene, reverse: bool = False) -> Body:
        """Return the body of the ego; with `reverse`, in the frame of `FrenetScene.backwards`."""
        lever_m = view.ego.limits.wheelbase_m / 2
        return cls(view.ego.length_m / 2, view.ego.width_m / 2, -lever_m if reverse else lever_m)

    @property
    def half(self) -> HalfSize:
        """Half length and half width (m)."""
        return self.half_length_m, self.half_width_m

    def center(self, axle_s: Any, axle_d: Any, yaw_rad: Any) -> tuple[Array, Array]:
        """Return arc length and offset of the box center (m) for poses of the axle."""
        return axle_s + self.lever_m * np.cos(yaw_rad), axle_d + self.lever_m * np.sin(yaw_rad)

    def axle(self, s: float, d: float, yaw_rad: float) -> tuple[float, float]:
        """Return arc length and offset of the axle (m) for a pose of the box center."""
        return s - self.lever_m * float(np.cos(yaw_rad)), d - self.lever_m * float(np.sin(yaw_rad))

    def reach(self, yaw_rad: Array) -> Array:
        """Half extent of the box across the road (m) at these headings."""
        reach: Array = self.half_width_m * np.abs(np.cos(yaw_rad)) + self.half_length_m * np.abs(np.sin(yaw_rad))
        return reach


@dataclass(frozen=True)
class Obstacles:
    """Stationary objects with the clearances to keep from them. Arrays have shape (objects,).

    Attributes:
        ids: Ids of the objects.
        s, d, yaw: Poses of their boxes (m, m, rad).
        half_length, half_width: Half sizes of their boxes (m).
        least: Smallest sufficient clearance (m).
        desired: Clearance from which on more room makes no path better (m).
    """

    ids: tuple[str, ...]
    s: Array
    d: Array
    yaw: Array
    half_length: Array
    half_width: Array
    least: Array
    desired: Array

    @property
    def pose(self) -> Pose:
        """Poses of the boxes (m, m, rad)."""
        return self.s, self.d, self.yaw

    @property
    def half(self) -> HalfSize:
        """Half sizes of the boxes (m)."""
        return self.half_length, self.half_width

    @property
    def _columns(self) -> tuple[Array, ...]:
        return self.s, self.d, self.yaw, self.half_length, self.half_width, self.least, self.desired

    def some(self, which: Array) -> Obstacles:
        """Return the objects with these indices; one may occur several times."""
        return Obstacles(tuple(self.ids[int(k)] for k in which), *(column[which] for column in self._columns))

    def with_reserve(self, reserve_m: float) -> Obstacles:
        """Return the same objects with larger clearances, by `reserve_m` (m)."""
        return replace(self, least=self.least + reserve_m, desired=np.maximum(self.desired, self.least + reserve_m))

    def columns(self) -> Obstacles:
        """Return the same objects as a column, to broadcast against headings."""
        return Obstacles(self.ids, *(column[:, None] for column in self._columns))

    def gaps(self, body: Body, s: Array, d: Array, yaw_rad: Array) -> Array:
        """(stations, objects): gaps to the box at center poses, each (stations,) (m)."""
        return separation((s[:, None], d[:, None], yaw_rad[:, None]), body.half, self.pose, self.half)


def blocked_offsets(
    body: Body, axle_s: Any, yaw_rad: Array, obstacles: Obstacles, clearance_m: Array
) -> tuple[Array, Array]:
    """Return the least and greatest offset of the axle at which the gap is below the clearance (m).

    The least is above the greatest where no offset is blocked. The arguments broadcast together. The gap is that of
    `separation`, so it errs on the safe side.
    """
    ahead_m = obstacles.s - (axle_s + body.lever_m * np.cos(yaw_rad))
    axes, _, _ = separating_axes((0.0, 0.0, yaw_rad), body.half, obstacles.pose, obstacles.half)
    low: Array | float = -np.inf
    high: Array | float = np.inf
    for x, y, reach in axes:
        across = np.where(np.abs(y) < PARALLEL, PARALLEL, y)
        middle, width = obstacles.d + ahead_m * (x / across), (reach + clearance_m) / np.abs(across)
        low, high = np.maximum(low, middle - width), np.minimum(high, middle + width)
    aside_m = body.lever_m * np.sin(yaw_rad)
    return low - aside_m, high - aside_m


@dataclass(frozen=True)
class Borders:
    """Right and left border of the area for the body, by arc length.

    Attributes:
        s: (stations,): arc lengths (m).
        right, left: (stations,): lateral offsets (m).
        beyond_m: Greatest reach of the body over a border that is allowed (m).
    """

    s: Array
    right: Array
    left: Array
    beyond_m: float

    def offsets(self, body: Body, axle_s: Array, yaw_rad: Array) -> tuple[Array, Array]:
        """Return the least and greatest offset of the axle at which the body stays within the borders (m)."""
        s, aside_m = body.center(axle_s, 0.0, yaw_rad)
        reach = body.reach(yaw_rad) - self.beyond_m
        return np.interp(s, self.s, self.right) + reach - aside_m, np.interp(s, self.s, self.left) - reach - aside_m

    def holds(self, body: Body, s: Array, d: Array, yaw_rad: Array, spare_m: float) -> Mask:
        """(stations,): True where the box at these center poses is within the borders, or `spare_m` beyond (m)."""
        reach = body.reach(yaw_rad) - self.beyond_m - spare_m
        right, left = np.interp(s, self.s, self.right), np.interp(s, self.s, self.left)
        result: Mask = (d - reach >= right) & (d + reach <= left)
        return result
