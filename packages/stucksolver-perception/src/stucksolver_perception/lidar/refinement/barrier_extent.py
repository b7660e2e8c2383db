"""How far barriers and cones close ahead reach, measured by the returns from them.

The network joins a barrier and the cone beside it to one wide box, along the vehicle's own axis, and places a cone up
to 0.3 m beside where it stands. A ray that came back from beyond passed through the air, though: nothing stands where
it passed. What remains of the network's box is what was hit, and the shadow of that. The direction of a barrier's box
is that in which the returns lie along its edges (Zhang, Xu, Dong and Dolan, "Efficient L-Shape Fitting for Vehicle
Detection Using Laser Scanners", 2017).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.free_space import OVERHEAD_M
from stucksolver_perception.ground import ground_heights
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections, Floats
from stucksolver_perception.rig import LidarRig
from stucksolver_perception.tracking.association import SAME_PLACE_M

BARRIER = LABELS.index("barrier")
CONE = LABELS.index("cone")
PERSON = LABELS.index("pedestrian")
NEAR_M = 20.0
"""Farther away, too few rays pass beside a thing."""
LEAST_M = 1.0
"""A barrier whose box is narrower is not measured: the arm of a gate may lie between two rings, so that rays pass it
by.
"""
SECTOR_RAD = math.radians(1.0)
LEAST_DEEP_M = 0.3
"""What returns a ray is at least this deep: a cone."""
BEFORE_M = 0.1
"""It may begin this far before its nearest return."""
STEP_RAD = math.radians(2.0)
EDGE_M = 0.1
"""Returns nearer to an edge than this lie on it."""


@dataclass(frozen=True)
class Measure:
    """How the things of one label are measured."""

    outside_m: float
    """Their returns lie up to this far outside of the network's box."""
    stands_m: float
    """Returns this high above the ground come from them."""
    passes_share: float
    """A ray that passes higher than this share of their height may have passed above them, or beside a narrow top."""
    fewest: int
    """Returns from one of them."""
    passed: int
    """So many returns from beyond show that a sector is free; 0 for what is solid and smaller than a sector."""
    narrowest_m: float = 0.0
    """They are at least this wide: fewer returns come from the foot of a cone, lower than `stands_m`."""
    widest_m: float = math.inf
    """If they seem wider, the returns beside the network's box come from something else."""
    turned: bool = False
    """True if the returns show its direction; otherwise its box is along the ray to it."""


MEASURES = {
    BARRIER: Measure(outside_m=0.2, stands_m=0.3, passes_share=0.8, fewest=30, passed=3, turned=True),
    CONE: Measure(outside_m=0.3, stands_m=0.15, passes_share=0.45, fewest=4, passed=0, narrowest_m=0.42, widest_m=0.5),
}


def with_measured_extents(detections: Detections, points: NDArray[np.floating], lidar: LidarRig) -> Detections:
    """Return the detections; where rays passed through the box of a barrier or cone nearby, without that part of it.

    Args:
        detections: In the vehicle frame.
        points: (n, 3 or more): x, y, z (m) of the last sweeps in the vehicle frame at the same time.
        lidar: Where the LiDAR is mounted, and how it turns.
    """
    center, size, yaw = detections.center.copy(), detections.size.copy(), detections.yaw.copy()
    foot = np.array([lidar.mount.x_m, lidar.mount.y_m])
    away = np.hypot(center[:, 0] - foot[0], center[:, 1] - foot[1])
    fits = (detections.label == CONE) | ((detections.label == BARRIER) & (size[:, :2].min(axis=1) >= LEAST_M))
    which = np.flatnonzero(fits & (away < NEAR_M))
    if not len(which):
        return detections
    returns = _Returns.near(points, lidar)
    for i in which:
        box, measure = _Box(center[i, :2] - foot, size[i, :2], float(yaw[i])), MEASURES[int(detections.label[i])]
        below_m = measure.passes_share * float(size[i, 2])
        found = _measured(box, returns, measure, below_m)
        if found is not None and found.sides.max() > measure.widest_m:
            found = _measured(box, returns, replace(measure, outside_m=0.0), below_m)
        if found is not None:
            center[_same_under_other_names(detections, int(i)) & ~fits, :2] += found.middle + foot - center[i, :2]
            center[i, :2], size[i, :2], yaw[i] = found.middle + foot, found.sides, found.yaw
    return replace(detections, center=center, size=size, yaw=yaw)


def _same_under_other_names(detections: Detections, i: int) -> NDArray[np.bool_]:
    """(n,): True for what the network found at the place of detection `i` with another label.

    It moves with it. Otherwise a cone that the network also takes for a weak animal would become a cone and an animal
    beside it. A person stays where it was found: people stand close to things.
    """
    away = np.hypot(*(detections.center[:, :2] - detections.center[i, :2]).T)
    return np.asarray((away < SAME_PLACE_M) & (detections.label != detections.label[i]) & (detections.label != PERSON))


@dataclass(frozen=True, eq=False)
class _Returns:
    """Returns from things and from the ground, around the LiDAR's foot."""

    places: Floats
    """(n, 2) (m)."""
    distance: Floats
    azimuth: Floats
    above: Floats
    """(n,): distances (m), directions (rad), and heights above the ground (m)."""
    up_m: float
    """Height of the LiDAR."""
    column_rad: float
    """Angle between two columns of its rays."""

    @staticmethod
    def near(points: NDArray[np.floating], lidar: LidarRig) -> _Returns:
        """Return those of the last sweeps (n, 3 or more) as far as they matter here."""
        x, y, z = (np.asarray(points[:, axis], np.float64) for axis in range(3))
        x, y = x - lidar.mount.x_m, y - lidar.mount.y_m
        distance, azimuth = np.hypot(x, y), np.arctan2(y, x)
        above = z - ground_heights(azimuth, distance, z)
        kept = (above < OVERHEAD_M) & (distance < 2.0 * NEAR_M)
        columns = lidar.points_per_s / (lidar.channels * lidar.turns_per_s)
        places = np.column_stack([x, y])
        return _Returns(places[kept], distance[kept], azimuth[kept], above[kept], lidar.mount.z_m, math.tau / columns)

    def part(self, which: NDArray[np.bool_]) -> _Returns:
        """Return some of them; `which` (n,)."""
        columns = self.places[which], self.distance[which], self.azimuth[which], self.above[which]
        return _Returns(*columns, self.up_m, self.column_rad)


class _Box:
    """A rectangle around the LiDAR's foot: its middle, sides (length, width) (m) and direction (rad)."""

    def __init__(self, middle: Floats, sides: Floats, yaw: float) -> None:
        self.middle, self.sides, self.yaw = middle, sides, yaw
        self.axes = _axes(yaw)

    def holds(self, places: Floats, margin_m: float) -> NDArray[np.bool_]:
        """(n,): True for the places (n, 2) in the box, grown by a margin (m)."""
        return np.asarray((np.abs((places - self.middle) @ self.axes.T) < self.sides / 2 + margin_m).all(axis=1))

    def corners(self) -> Floats:
        """(4, 2) (m)."""
        signs = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)])
        return np.asarray(self.middle + (signs * self.sides / 2) @ self.axes)

    def chord(self, azimuth: float) -> tuple[float, float] | None:
        """Return where a ray from the LiDAR's foot enters and leaves the box (m); None if it passes by."""
        along = self.axes @ np.array([math.cos(azimuth), math.sin(azimuth)])
        # A ray along a side never crosses it: no direction is exactly that.
        along = np.where(np.abs(along) < 1e-9, 1e-9, along)
        start = -self.axes @ self.middle
        first, second = (-self.sides / 2 - start) / along, (self.sides / 2 - start) / along
        enters, leaves = max(float(np.minimum(first, second).max()), 0.0), float(np.maximum(first, second).min())
        return (enters, leaves) if leaves > enters else None


def _axes(yaw: float) -> Floats:
    """(2, 2): unit vectors along and across a direction (rad)."""
    return np.array([(math.cos(yaw), math.sin(yaw)), (-math.sin(yaw), math.cos(yaw))])


def _measured(box: _Box, returns: _Returns, measure: Measure, below_m: float) -> _Box | None:
    """Return the part of a box that may be filled, as a box; None if there are too few returns to say."""
    ahead = math.atan2(box.middle[1], box.middle[0])
    corners = box.corners()
    edges = _turned(np.arctan2(corners[:, 1], corners[:, 0]), ahead)
    beside = np.abs(edges).max() + math.atan2(measure.outside_m, np.hypot(*box.middle)) + SECTOR_RAD
    returns = returns.part(np.abs(_turned(returns.azimuth, ahead)) < beside)
    hit = (returns.above > measure.stands_m) & box.holds(returns.places, measure.outside_m)
    if hit.sum() < measure.fewest:
        return None
    aside = _turned(returns.azimuth, ahead)
    sector = np.floor(aside / SECTOR_RAD).astype(np.int64)
    first, last = min(edges.min(), aside[hit].min()), max(edges.max(), aside[hit].max())
    filled = [returns.places[hit]]
    for k in range(math.floor(first / SECTOR_RAD), math.ceil(last / SECTOR_RAD)):
        angles, nearest_m = _filled_part(box, k, returns, aside, sector == k, hit, below_m, measure.passed)
        for angle in angles:
            chord = box.chord(ahead + angle)
            begins = chord[0] if nearest_m is None and chord is not None else nearest_m
            if begins is None:
                continue
            # The depth of what is larger is not known beyond what the network says.
            ends = chord[1] if chord is not None and measure.passed else begins
            reach = np.array([begins, ends if nearest_m is None else max(ends, begins + LEAST_DEEP_M)])
            filled.append(reach[:, None] * (math.cos(ahead + angle), math.sin(ahead + angle)))
    around = _around(np.concatenate(filled), _direction(returns.places[hit]) if measure.turned else ahead, box.yaw)
    return _Box(around.middle, np.maximum(around.sides, measure.narrowest_m), around.yaw)


def _turned(azimuth: Floats, ahead: float) -> Floats:
    """Return directions from another one (rad, -pi to pi)."""
    return np.asarray(np.remainder(azimuth - ahead + math.pi, math.tau) - math.pi)


def _filled_part(
    box: _Box,
    k: int,
    returns: _Returns,
    aside: Floats,
    here: NDArray[np.bool_],
    hit: NDArray[np.bool_],
    below_m: float,
    passed: int,
) -> tuple[list[float], float | None]:
    """Return the directions in sector `k` between which the box may be filled (rad), and from where on (m).

    `here` (n,) are the returns of the sector and `hit` (n,) those of the thing. The distance is None if there was no
    return from it.
    """
    first, last = k * SECTOR_RAD, (k + 1) * SECTOR_RAD
    own = here & hit
    ahead = math.atan2(box.middle[1], box.middle[0])
    chords = [box.chord(ahead + angle) for angle in (first, (first + last) / 2, last)]
    nearest_m = float(returns.distance[own].min()) if own.any() else None
    known = [chord[0] for chord in chords if chord is not None] + ([] if nearest_m is None else [nearest_m])
    if not known:
        return [], None
    beyond = here & ~hit & (returns.distance > min(known) + BEFORE_M)
    # The ray came down from the LiDAR: so high it was where the thing is.
    height = returns.up_m + (returns.above - returns.up_m) * min(known) / np.maximum(returns.distance, EDGE_M)
    beyond &= height < below_m
    if nearest_m is None:
        return ([], None) if beyond.sum() >= passed else ([first, (first + last) / 2, last], None)
    low, high = float(aside[own].min()), float(aside[own].max())
    # Rays that passed beside the outermost return show that it ends before the next column.
    low = max(low - returns.column_rad, first) if (beyond & (aside < low)).sum() >= passed else first
    high = min(high + returns.column_rad, last) if (beyond & (aside > high)).sum() >= passed else last
    return [low, high], nearest_m - BEFORE_M


def _direction(places: Floats) -> float:
    """Return the direction along whose rectangle's edges most of the places (n, 2) lie, within a quarter turn (rad)."""
    angles = np.arange(0.0, math.pi / 2, STEP_RAD)
    cos, sin = np.cos(angles)[:, None], np.sin(angles)[:, None]
    x, y = places.T
    first, second = cos * x + sin * y, cos * y - sin * x
    off = np.minimum(_to_edge(first), _to_edge(second))
    return float(angles[(1.0 / np.maximum(off, EDGE_M)).sum(axis=1).argmax()])


def _to_edge(along: Floats) -> Floats:
    """(angles, n): distance of each place from the nearer end of all (m)."""
    result: Floats = np.minimum(along - along.min(axis=1, keepdims=True), along.max(axis=1, keepdims=True) - along)
    return result


def _around(places: Floats, direction: float, like: float) -> _Box:
    """Return the box in a direction around places (n, 2), whose length is the side nearest to the direction `like`."""
    yaw = direction + round((like - direction) / (math.pi / 2)) * (math.pi / 2)
    axes = _axes(yaw)
    along = places @ axes.T
    low, high = along.min(axis=0), along.max(axis=0)
    return _Box((low + high) / 2 @ axes, high - low, yaw)
