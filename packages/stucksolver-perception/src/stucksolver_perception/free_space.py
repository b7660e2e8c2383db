"""Computes free space from the LiDAR's points: in each direction, the cells that are proven to be empty.

Only a ray that came back is evidence. A ray that hit the ground passed through all cells before it. On the last part of
its path it was so low that an object of `height_m` would have blocked it, so that part is free. A ray that hit an
object proves the same up to that object. The object's shadow is unknown, even if other rays in the same direction
passed next to the object. A ray that did not come back proves nothing: it may have gone to the sky or been lost
(drop-off, wet or black surfaces). With 64 channels between +10 and -30 degrees, 2.5 m above the ground, the last rays
hit the ground at 40 to 60 m; beyond that, all space is unknown.

Assumptions, to be checked for a new vehicle:

* Objects lower than `height_m` are not covered here. They are the detector's task.
* An object as tall as `height_m` is solid and as wide as a bin (1 degree: 0.35 m at 20 m, 0.9 m at 50 m), or it returns
  rays itself. If an object's edge runs through a bin, the bin counts as free: an error of up to a degree.
* The ground's slope changes slowly (`ground_heights`). Where it rises faster, the ground counts as an object.
* The points are those of one full turn, all moved to one time. Vehicles may have entered the space in the last 0.1 s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.ground import ground_heights
from stucksolver_perception.measurements import Floats
from stucksolver_perception.rig import LidarRig

AZIMUTHS = 360
"""Number of directions, in bins of 1 degree. A bin has 2.6 columns of the LiDAR, so that drop-off seldom removes a
whole ring from one."""
CELL_M = 0.5
"""Length of a cell (m). Ours."""
HEIGHT_M = 1.0
"""Height of the lowest object that free space excludes (m): pedestrians, two-wheelers and vehicles, not cones, animals
or debris."""
GROUND_M = 0.3
"""Height above the ground below which a return counts as the ground, with noise and curbs (m). Ours."""
OVERHEAD_M = 2.2
"""Height above the ground from which objects let vehicles pass below (m): signs, branches, bridges. Ours."""
EGO_RANGE_M = 3.0
"""Distance from the LiDAR's foot below which no cell is free (m): the ego is there, and the lowest beams miss the
ground."""
EGO_HALF_LENGTH_M = 2.6
"""Half length of the ego around its reference point (m). Returns from within come from the ego itself. Ours."""
EGO_HALF_WIDTH_M = 1.2
"""Half width of the ego, with its mirrors (m). Ours."""
BODY_M = 2.0
"""Minimum depth of an object that was hit (m): a bicycle occupies space, although rays pass through it. Ours."""
FACE_M = 0.5
"""Distance before a return that is not free (m): an object may lean, and its nearest part may return no ray. Ours."""
BODY_MARGIN_M = 0.3
"""Margin around an object's box within which returns come from the object (m): the box's error, and mirrors. Ours."""
BRIDGE_M = 1.0
"""Maximum length of an unknown stretch of a line that is skipped (m): the shadow of a post hides no vehicle."""
GAP_BINS = 1
"""Number of bins without a return that count as free between two free ones, if they have no shadow there. Ours."""


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """A polar map around the LiDAR; queries are in the vehicle frame. Create it with `from_points`."""

    cells: NDArray[np.bool_]
    """(AZIMUTHS, cells of CELL_M): True if the cell is free of objects of this height. Bin 0 begins at -pi."""
    blocked_m: Floats
    """(AZIMUTHS,): distance of the nearest tall return (m), between `height_m` and `OVERHEAD_M` above the ground;
    infinite without one."""
    far_m: Floats
    """(AZIMUTHS,): sight distance of another sensor (m); 0 without one."""
    origin: tuple[float, float]
    """The LiDAR's x, y in the vehicle frame (m)."""
    tall: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    """(n, 2): x, y of the tall returns, from the LiDAR's foot along the vehicle's axes (m)."""

    @staticmethod
    def from_points(points: NDArray[np.floating], lidar: LidarRig, height_m: float = HEIGHT_M) -> FreeSpace:
        """Return the free space of one full turn.

        Args:
            points: (n, 3 or more): x, y, z (m) in the vehicle frame, of the last full turn.
            lidar: Position and range of the LiDAR.
            height_m: Height of the lowest object that free space excludes (m).
        """
        mount = lidar.mount
        x, y, z = (np.asarray(points[:, axis], np.float64) for axis in range(3))
        in_ego = (np.abs(x) < EGO_HALF_LENGTH_M) & (np.abs(y) < EGO_HALF_WIDTH_M)
        x, y, z = x[~in_ego] - mount.x_m, y[~in_ego] - mount.y_m, z[~in_ego]
        distance = np.hypot(x, y)
        azimuth = np.arctan2(y, x)
        above = z - ground_heights(azimuth, distance, z)
        bins = _bins(azimuth)
        count = math.ceil(lidar.range_m / CELL_M)
        cells = _cells_below_rays(bins, distance, above, mount.z_m, height_m, count)
        tall = (above >= height_m) & (above < OVERHEAD_M)
        blocked = np.full(AZIMUTHS, np.inf)
        np.minimum.at(blocked, bins[tall], distance[tall])
        objects = (above > GROUND_M) & (above < OVERHEAD_M)
        shadows = _shadows(bins[objects], distance[objects], above[objects], mount.z_m, height_m, count)
        cells = _without_gaps(cells & ~shadows, shadows)
        cells[:, : int(EGO_RANGE_M / CELL_M)] = False
        foot = (mount.x_m, mount.y_m)
        return FreeSpace(cells, blocked, np.zeros(AZIMUTHS), foot, np.column_stack([x[tall], y[tall]]))

    def blocked_otherwise(self, bodies: Floats) -> Floats:
        """Return (AZIMUTHS,): `blocked_m` without the returns from these boxes (n, 5; see `within`)."""
        blocked = np.full(AZIMUTHS, np.inf)
        x, y = self.tall[:, 0], self.tall[:, 1]
        unexplained = ~within(bodies, x + self.origin[0], y + self.origin[1], BODY_MARGIN_M, BODY_MARGIN_M)
        np.minimum.at(blocked, _bins(np.arctan2(y, x))[unexplained], np.hypot(x, y)[unexplained])
        return blocked

    def is_proven_free(self, x: Floats, y: Floats) -> NDArray[np.bool_]:
        """Return (n,): True if the point is proven free (m, vehicle frame)."""
        dx, dy = np.asarray(x) - self.origin[0], np.asarray(y) - self.origin[1]
        distance, bins = np.hypot(dx, dy), _bins(np.arctan2(dy, dx))
        cell = (distance / CELL_M).astype(np.int64)
        in_range = cell < self.cells.shape[1]
        lidar_free = in_range & self.cells[bins, np.where(in_range, cell, 0)]
        return np.asarray(lidar_free | ((distance >= EGO_RANGE_M) & (distance <= self.far_m[bins])))

    def free_length_along_m(self, polyline: Floats, bridge_m: float = BRIDGE_M, known: Floats | None = None) -> float:
        """Return the length of a line (k, 2; vehicle frame) that is free from its start without a break (m).

        The part within `EGO_RANGE_M` of the LiDAR is skipped, because the ego is there, and so are breaks up to
        `bridge_m`. The length ends at the last free point, so it is never longer than the line.

        `known` (n, 5) has the boxes of objects that are checked separately: x, y, yaw, half length and half width (m,
        rad; vehicle frame). A break at one of them is skipped too. The area that it hides beyond itself is not.
        """
        line = np.asarray(polyline, np.float64)[:, :2]
        if len(line) < 2:
            return 0.0
        stations = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
        samples = np.append(np.arange(0.0, stations[-1], CELL_M / 2.0), stations[-1])
        x, y = np.interp(samples, stations, line[:, 0]), np.interp(samples, stations, line[:, 1])
        near_ego = np.hypot(x - self.origin[0], y - self.origin[1]) < EGO_RANGE_M
        # The margins are those by which the map widens the area around a return.
        in_known = np.zeros(len(samples), np.bool_) if known is None else within(known, x, y, BODY_M, FACE_M)
        free = samples[self.is_proven_free(x, y) | near_ego | in_known]
        if not len(free) or free[0] > bridge_m:
            return 0.0
        breaks = np.flatnonzero(np.diff(free) > bridge_m + CELL_M / 2.0)
        return float(free[breaks[0]] if len(breaks) else free[-1])

    def extended(self, azimuth_rad: Floats, ahead_m: Floats) -> FreeSpace:
        """Return the free space with the sight distances of another sensor, such as the camera in its cone.

        A sight distance is limited to the distance of the LiDAR's nearest tall return.

        Args:
            azimuth_rad: (k,): directions from the LiDAR's foot, in the vehicle frame; ascending, at least two. Bins
                whose center lies outside of them are not changed.
            ahead_m: (k,): sight distance in each direction (m). Between two directions, the smaller one counts.

        Raises:
            ValueError: The directions are fewer than two, do not ascend, or do not match the distances.
        """
        azimuth, ahead = np.asarray(azimuth_rad, np.float64), np.asarray(ahead_m, np.float64)
        if len(azimuth) < 2 or len(azimuth) != len(ahead) or bool((np.diff(azimuth) <= 0.0).any()):
            raise ValueError("extended() requires two or more ascending azimuths, and one distance for each")
        centers = (np.arange(AZIMUTHS) + 0.5) / AZIMUTHS * math.tau - math.pi
        following = np.clip(np.searchsorted(azimuth, centers), 1, len(azimuth) - 1)
        inside = (centers >= azimuth[0]) & (centers <= azimuth[-1])
        sight_m = np.where(inside, np.minimum(ahead[following - 1], ahead[following]), 0.0)
        far = np.minimum(sight_m, self.blocked_m)
        return replace(self, far_m=np.maximum(self.far_m, far))


def footprints(boxes: Floats) -> Floats:
    """Return (n, 5): the arguments of `within` for boxes (n, 7 or more): x, y, z, length, width, height, yaw (m,
    rad).
    """
    return np.column_stack([boxes[:, :2], boxes[:, 6], boxes[:, 3] / 2, boxes[:, 4] / 2])


def within(bodies: Floats, x: Floats, y: Floats, ends_m: float, sides_m: float) -> NDArray[np.bool_]:
    """Return (n,): True for points in one of the boxes, with a margin.

    Args:
        bodies: (m, 5): x, y, yaw, half length, half width of each box (m, rad).
        x: (n,): x of the points in the same frame (m).
        y: (n,): y of the points (m).
        ends_m: Margin at either end of a box (m).
        sides_m: Margin on either side of it (m).
    """
    dx, dy = x[:, None] - bodies[:, 0], y[:, None] - bodies[:, 1]
    cos, sin = np.cos(bodies[:, 2]), np.sin(bodies[:, 2])
    along, across = np.abs(dx * cos + dy * sin), np.abs(dy * cos - dx * sin)
    return np.asarray(((along < bodies[:, 3] + ends_m) & (across < bodies[:, 4] + sides_m)).any(axis=1))


def _bins(azimuth: Floats) -> NDArray[np.int64]:
    return np.minimum(((azimuth + math.pi) / math.tau * AZIMUTHS).astype(np.int64), AZIMUTHS - 1)


def _cells_below_rays(
    bins: NDArray[np.int64], distance: Floats, above: Floats, up: float, height_m: float, count: int
) -> NDArray[np.bool_]:
    """Return (AZIMUTHS, count): True for cells through which a ray passed lower than `height_m`.

    A ray descends from the LiDAR's height `up` to `above` at its end. From similar triangles, it is below `height_m`
    beyond the share (up - height) / (up - above) of its length. Only entire cells up to the return count.
    """
    useful = (above < height_m) & (distance > 0.0)
    end = distance[useful]
    start = end * (up - height_m) / (up - np.where(above[useful] < GROUND_M, 0.0, above[useful]))
    first = np.ceil(start / CELL_M).astype(np.int64)
    # A ray that hit the ground proves that the cell of its end is free. On an object, only the cells before it are.
    last = np.floor(end / CELL_M).astype(np.int64) + np.where(above[useful] < GROUND_M, 1, 0)
    last = np.minimum(last, count)
    entire = first < last
    return _filled(bins[useful][entire], first[entire], last[entire], count)


def _shadows(
    bins: NDArray[np.int64], distance: Floats, above: Floats, up: float, height_m: float, count: int
) -> NDArray[np.bool_]:
    """Return (AZIMUTHS, count): True for cells that objects occupy, or hide up to the height `height_m`."""
    shadow_ratio = (up - height_m) / np.maximum(0.01, up - above)
    last = np.minimum(count, np.ceil(np.maximum(distance + BODY_M, distance * shadow_ratio) / CELL_M))
    first = np.clip(np.floor((distance - FACE_M) / CELL_M), 0, count)
    return _filled(bins, first.astype(np.int64), last.astype(np.int64), count)


def _filled(
    bins: NDArray[np.int64], first: NDArray[np.int64], last: NDArray[np.int64], count: int
) -> NDArray[np.bool_]:
    """Return (AZIMUTHS, count): True for cells in any of the spans from `first` to `last` (exclusive)."""
    row, size = bins * (count + 1), AZIMUTHS * (count + 1)
    entered = np.bincount(row + first, minlength=size) - np.bincount(row + last, minlength=size)
    return np.asarray(entered.reshape(AZIMUTHS, count + 1).cumsum(1)[:, :count] > 0)


def _without_gaps(cells: NDArray[np.bool_], shadows: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the cells with gaps of `GAP_BINS` directions closed, except in shadows."""
    left = right = np.zeros_like(cells)
    for step in range(1, GAP_BINS + 1):
        left, right = left | np.roll(cells, step, 0), right | np.roll(cells, -step, 0)
    return cells | (left & right & ~shadows)
