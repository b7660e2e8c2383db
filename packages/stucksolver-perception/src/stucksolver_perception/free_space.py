"""Not seen is not free: how far, in each direction, the LiDAR saw that nothing is there.

Only a ray that came back is evidence. A ray that hit the ground at distance r passed through everything before it, and
over the last part of its path it was so low that an object of `height_m` would have blocked it: that part was seen to
be free. A ray that hit an object shows the same up to that object. The object's shadow was not seen, even if other rays
in the same direction passed beside it. A ray that did not come back shows nothing: it may have gone to the sky or been
lost (drop-off, wet or black surfaces). With 64 channels between +10 and -30 degrees, 2.5 m up, the last rays hit the
ground at 40 to 60 m; beyond that, nothing was seen.

Assumptions to be checked for a new vehicle:

* Objects lower than `height_m` are not covered here. They are the detector's task.
* An object as tall as `height_m` is solid and as wide as a bin (1 degree: 0.35 m at 20 m, 0.9 m at 50 m), or it returns
  rays itself. If an object's edge runs through a bin, the bin counts as seen: an error of up to a degree.
* The ground's slope changes slowly (`ground_heights`). Where it rises faster, it counts as an object that hides.
* The points are those of one full turn, all moved to one moment. Space seen 0.1 s ago may have been entered since.
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
"""Bins of 1 degree: 2.6 columns of the LiDAR each, so that drop-off seldom takes a whole ring out of one."""
CELL_M = 0.5
HEIGHT_M = 1.0
"""A claim of free space is about people, two-wheelers and vehicles; not cones, animals or debris."""
GROUND_M = 0.3
"""A lower return above the ground is the ground, with noise and curbs."""
OVERHEAD_M = 2.2
"""Anything that begins higher lets vehicles pass below: signs, branches, bridges."""
OWN_M = 3.0
"""Around the LiDAR's foot: the vehicle itself, and what its lowest beams miss. Never claimed to be seen."""
OWN_LENGTH_M = 2.6
OWN_WIDTH_M = 1.2
"""Half sizes around the reference point: returns from within come from the vehicle itself."""
BODY_M = 2.0
"""An object that was hit is assumed at least this deep: a bicycle lets rays through, but is there."""
FACE_M = 0.5
"""The cell before a return is left out: the object may lean, and its nearest part need not have returned a ray."""
BODY_MARGIN_M = 0.3
"""Returns from a body lie up to this far outside of its box: the error of the box, and mirrors."""
BRIDGE_M = 1.0
"""Hidden stretches of a line up to this length are skipped: the shadow of a post hides no vehicle."""
GAP_BINS = 1
"""This many bins without a return between two seen ones count as seen, if nothing is nearer."""


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """A polar map around the LiDAR, made by `from_points`; queried in the vehicle frame."""

    cells: NDArray[np.bool_]
    """(AZIMUTHS, cells of CELL_M): True if an object of this height would have been seen there. Bin 0 begins at -pi."""
    blocked_m: Floats
    """(AZIMUTHS,): distance of the nearest return between the height and `OVERHEAD_M` above ground; inf without one."""
    far_m: Floats
    """(AZIMUTHS,): how far another sensor saw; 0 without one."""
    origin: tuple[float, float]
    """The LiDAR's x, y in the vehicle frame (m)."""
    tall: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    """(n, 2): x, y of the returns that `blocked_m` is about, from the LiDAR's foot along the vehicle's axes (m)."""

    @staticmethod
    def from_points(points: NDArray[np.floating], lidar: LidarRig, height_m: float = HEIGHT_M) -> FreeSpace:
        """Return what one full turn saw.

        Args:
            points: (n, 3 or more): x, y, z (m) in the vehicle frame, of the last full turn.
            lidar: Position and range of the LiDAR.
            height_m: Height of the objects that are claimed to be absent (m).
        """
        mount = lidar.mount
        x, y, z = (np.asarray(points[:, axis], np.float64) for axis in range(3))
        own = (np.abs(x) < OWN_LENGTH_M) & (np.abs(y) < OWN_WIDTH_M)
        x, y, z = x[~own] - mount.x_m, y[~own] - mount.y_m, z[~own]
        distance = np.hypot(x, y)
        azimuth = np.arctan2(y, x)
        above = z - ground_heights(azimuth, distance, z)
        bins = _bins(azimuth)
        count = math.ceil(lidar.range_m / CELL_M)
        cells = _swept(bins, distance, above, mount.z_m, height_m, count)
        tall = (above >= height_m) & (above < OVERHEAD_M)
        blocked = np.full(AZIMUTHS, np.inf)
        np.minimum.at(blocked, bins[tall], distance[tall])
        standing = (above > GROUND_M) & (above < OVERHEAD_M)
        shadows = _shadows(bins[standing], distance[standing], above[standing], mount.z_m, height_m, count)
        cells = _without_gaps(cells & ~shadows, shadows)
        cells[:, : int(OWN_M / CELL_M)] = False
        foot = (mount.x_m, mount.y_m)
        return FreeSpace(cells, blocked, np.zeros(AZIMUTHS), foot, np.column_stack([x[tall], y[tall]]))

    def blocked_otherwise(self, bodies: Floats) -> Floats:
        """(AZIMUTHS,): `blocked_m` without the returns from these bodies (n, 5; see `within`)."""
        blocked = np.full(AZIMUTHS, np.inf)
        x, y = self.tall[:, 0], self.tall[:, 1]
        rest = ~within(bodies, x + self.origin[0], y + self.origin[1], BODY_MARGIN_M, BODY_MARGIN_M)
        np.minimum.at(blocked, _bins(np.arctan2(y, x))[rest], np.hypot(x, y)[rest])
        return blocked

    def is_proven_free(self, x: Floats, y: Floats) -> NDArray[np.bool_]:
        """(n,): True if it was seen that nothing stands at these places of the vehicle frame (m)."""
        dx, dy = np.asarray(x) - self.origin[0], np.asarray(y) - self.origin[1]
        distance, bins = np.hypot(dx, dy), _bins(np.arctan2(dy, dx))
        cell = (distance / CELL_M).astype(np.int64)
        within = cell < self.cells.shape[1]
        by_lidar = within & self.cells[bins, np.where(within, cell, 0)]
        return np.asarray(by_lidar | ((distance >= OWN_M) & (distance <= self.far_m[bins])))

    def free_length_along_m(self, polyline: Floats, bridge_m: float = BRIDGE_M, known: Floats | None = None) -> float:
        """Return the meters of a line (k, 2; vehicle frame) that were seen from its beginning without a break.

        The part within `OWN_M` of the LiDAR is skipped, since the vehicle itself stands there, and so are breaks up to
        `bridge_m`. The end is the last place seen, so the result is never longer than the line.

        `known` (n, 5) are bodies that somebody else keeps track of: x, y, yaw, half length and half width (m, rad;
        vehicle frame). A break where one of them is, is skipped as well. What it hides beyond itself is not.
        """
        line = np.asarray(polyline, np.float64)[:, :2]
        if len(line) < 2:
            return 0.0
        stations = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
        at = np.append(np.arange(0.0, stations[-1], CELL_M / 2.0), stations[-1])
        x, y = np.interp(at, stations, line[:, 0]), np.interp(at, stations, line[:, 1])
        own = np.hypot(x - self.origin[0], y - self.origin[1]) < OWN_M
        # Around a return, the map leaves out as much.
        taken = np.zeros(len(at), np.bool_) if known is None else within(known, x, y, BODY_M, FACE_M)
        seen = at[self.is_proven_free(x, y) | own | taken]
        if not len(seen) or seen[0] > bridge_m:
            return 0.0
        breaks = np.flatnonzero(np.diff(seen) > bridge_m + CELL_M / 2.0)
        return float(seen[breaks[0]] if len(breaks) else seen[-1])

    def extended(self, azimuth_rad: Floats, ahead_m: Floats) -> FreeSpace:
        """Join with another sensor: in the camera's cone, how far a vehicle would have been detected.

        If the LiDAR found a tall object nearer than that, the other's claim ends there.

        Args:
            azimuth_rad: (k,): directions from the LiDAR's foot, vehicle frame; ascending, at least two. Bins whose
                center lies outside of them are not changed.
            ahead_m: (k,): how far was seen in each (m); between two directions, the smaller one counts.
        """
        azimuth, ahead = np.asarray(azimuth_rad, np.float64), np.asarray(ahead_m, np.float64)
        if len(azimuth) < 2 or len(azimuth) != len(ahead) or bool((np.diff(azimuth) <= 0.0).any()):
            raise ValueError("extended() needs two or more ascending azimuths, and one distance for each")
        middle = (np.arange(AZIMUTHS) + 0.5) / AZIMUTHS * math.tau - math.pi
        after = np.clip(np.searchsorted(azimuth, middle), 1, len(azimuth) - 1)
        inside = (middle >= azimuth[0]) & (middle <= azimuth[-1])
        claimed = np.where(inside, np.minimum(ahead[after - 1], ahead[after]), 0.0)
        far = np.minimum(claimed, self.blocked_m)
        return replace(self, far_m=np.maximum(self.far_m, far))


def footprints(boxes: Floats) -> Floats:
    """(n, 5): bodies as `within` takes them, of boxes (n, 7 or more): x, y, z, length, width, height, yaw (m, rad)."""
    return np.column_stack([boxes[:, :2], boxes[:, 6], boxes[:, 3] / 2, boxes[:, 4] / 2])


def within(bodies: Floats, x: Floats, y: Floats, ends_m: float, sides_m: float) -> NDArray[np.bool_]:
    """(n,): True for the points in one of the bodies, each longer by `ends_m` at either end and wider by `sides_m` on
    either side.

    Args:
        bodies: (m, 5): x, y, yaw, half length, half width (m, rad).
        x: (n,): places in the same frame (m).
        y: (n,).
        ends_m: Margin along the bodies (m).
        sides_m: Margin across them (m).
    """
    dx, dy = x[:, None] - bodies[:, 0], y[:, None] - bodies[:, 1]
    cos, sin = np.cos(bodies[:, 2]), np.sin(bodies[:, 2])
    along, across = np.abs(dx * cos + dy * sin), np.abs(dy * cos - dx * sin)
    return np.asarray(((along < bodies[:, 3] + ends_m) & (across < bodies[:, 4] + sides_m)).any(axis=1))


def _bins(azimuth: Floats) -> NDArray[np.int64]:
    return np.minimum(((azimuth + math.pi) / math.tau * AZIMUTHS).astype(np.int64), AZIMUTHS - 1)


def _swept(
    bins: NDArray[np.int64], distance: Floats, above: Floats, up: float, height_m: float, count: int
) -> NDArray[np.bool_]:
    """(AZIMUTHS, count): cells through which some ray passed lower than `height_m`.

    A ray comes down from `up` to `above` at its end; by similar triangles it is below `height_m` from the share
    (up - height) / (up - above) of its way on. Only whole cells count: the last one is up to the return.
    """
    useful = (above < height_m) & (distance > 0.0)
    end = distance[useful]
    start = end * (up - height_m) / (up - np.where(above[useful] < GROUND_M, 0.0, above[useful]))
    first = np.ceil(start / CELL_M).astype(np.int64)
    # A ray that hit the ground saw the cell that it hit; one that hit an object, only the cells before.
    last = np.floor(end / CELL_M).astype(np.int64) + np.where(above[useful] < GROUND_M, 1, 0)
    last = np.minimum(last, count)
    whole = first < last
    return _filled(bins[useful][whole], first[whole], last[whole], count)


def _shadows(
    bins: NDArray[np.int64], distance: Floats, above: Floats, up: float, height_m: float, count: int
) -> NDArray[np.bool_]:
    """(AZIMUTHS, count): cells occupied by objects, and those behind where the line over the top is too high."""
    over = (up - height_m) / np.maximum(0.01, up - above)
    last = np.minimum(count, np.ceil(np.maximum(distance + BODY_M, distance * over) / CELL_M))
    first = np.clip(np.floor((distance - FACE_M) / CELL_M), 0, count)
    return _filled(bins, first.astype(np.int64), last.astype(np.int64), count)


def _filled(
    bins: NDArray[np.int64], first: NDArray[np.int64], last: NDArray[np.int64], count: int
) -> NDArray[np.bool_]:
    """(AZIMUTHS, count): cells in any of the spans from `first` up to, but not with, `last`."""
    row, size = bins * (count + 1), AZIMUTHS * (count + 1)
    entered = np.bincount(row + first, minlength=size) - np.bincount(row + last, minlength=size)
    return np.asarray(entered.reshape(AZIMUTHS, count + 1).cumsum(1)[:, :count] > 0)


def _without_gaps(cells: NDArray[np.bool_], shadows: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Close gaps of `GAP_BINS` between directions, where there is no shadow."""
    left = right = np.zeros_like(cells)
    for step in range(1, GAP_BINS + 1):
        left, right = left | np.roll(cells, step, 0), right | np.roll(cells, -step, 0)
    return cells | (left & right & ~shadows)
