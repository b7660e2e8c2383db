"""Measures the extents of nearby barriers and cones from their returns.

The network joins a barrier and the cone next to it to one wide box along the vehicle's axis, and its cones are up to
0.3 m away from the real ones. A ray that came back from beyond proves that the space it passed through is empty. The
measured box is the part of the network's box that returned rays, and its shadow. The direction of a barrier's box is
the one in which the returns lie along its edges (Zhang, Xu, Dong and Dolan, "Efficient L-Shape Fitting for Vehicle
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
from stucksolver_perception.tracking.association import SAME_POSITION_M

BARRIER = LABELS.index("barrier")
"""Index of the label."""
CONE = LABELS.index("cone")
"""Index of the label."""
PERSON = LABELS.index("pedestrian")
"""Index of the label."""
NEAR_M = 20.0
"""Maximum distance of a measured object (m). Farther away, too few rays pass next to an object. Ours."""
MIN_WIDTH_M = 1.0
"""Minimum width and length of a measured barrier (m). The arm of a gate may be between two rings, so that rays pass it.
Ours."""
SECTOR_RAD = math.radians(1.0)
"""Width of a sector, in which rays are evaluated together (rad). Ours."""
MIN_DEPTH_M = 0.3
"""Minimum depth of an object that returns a ray (m): that of a cone."""
FRONT_MARGIN_M = 0.1
"""Distance by which an object may begin before its nearest return (m). Ours."""
STEP_RAD = math.radians(2.0)
"""Difference between the directions that are compared (rad). Ours."""
EDGE_M = 0.1
"""Distance from an edge within which returns count as on it (m). Ours."""


@dataclass(frozen=True)
class MeasuringRule:
    """The rule for measuring the objects of one label. All values are ours."""

    outside_m: float
    """Maximum distance of an object's returns from the network's box (m)."""
    min_height_m: float
    """Minimum height of an object's returns above the ground (m)."""
    clear_share: float
    """Share of the object's height below which a ray must pass to prove that the space is empty. A higher ray may have
    passed above the object, or next to a narrow top."""
    min_returns: int
    """Minimum number of returns from an object."""
    min_beyond: int
    """Minimum number of returns from beyond that prove a sector to be empty; 0 for a solid object smaller than a
    sector."""
    min_width_m: float = 0.0
    """Minimum width and length (m). The foot of a cone is lower than `min_height_m`, so its returns do not count."""
    max_width_m: float = math.inf
    """Maximum width and length (m). If a measured box is larger, the returns outside of the network's box come from
    another object."""
    uses_edges: bool = False
    """True if the returns give the direction. Otherwise the box is along the ray to the object."""


MEASURING_RULES = {
    BARRIER: MeasuringRule(
        outside_m=0.2, min_height_m=0.3, clear_share=0.8, min_returns=30, min_beyond=3, uses_edges=True
    ),
    CONE: MeasuringRule(
        outside_m=0.3,
        min_height_m=0.15,
        clear_share=0.45,
        min_returns=4,
        min_beyond=0,
        min_width_m=0.42,
        max_width_m=0.5,
    ),
}


def with_measured_extents(detections: Detections, points: NDArray[np.floating], lidar: LidarRig) -> Detections:
    """Return the detections with measured boxes of nearby barriers and cones.

    Args:
        detections: Detections in the vehicle frame.
        points: (n, 3 or more): x, y, z (m) of the last sweeps in the vehicle frame at the same time.
        lidar: Mount and columns of the LiDAR.
    """
    center, size, yaw = detections.center.copy(), detections.size.copy(), detections.yaw.copy()
    foot = np.array([lidar.mount.x_m, lidar.mount.y_m])
    distance = np.hypot(center[:, 0] - foot[0], center[:, 1] - foot[1])
    is_measurable = (detections.label == CONE) | (
        (detections.label == BARRIER) & (size[:, :2].min(axis=1) >= MIN_WIDTH_M)
    )
    rows = np.flatnonzero(is_measurable & (distance < NEAR_M))
    if not len(rows):
        return detections
    returns = _Returns.near(points, lidar)
    for i in rows:
        box, rule = _Box(center[i, :2] - foot, size[i, :2], float(yaw[i])), MEASURING_RULES[int(detections.label[i])]
        below_m = rule.clear_share * float(size[i, 2])
        measured = _measure(box, returns, rule, below_m)
        if measured is not None and measured.sides.max() > rule.max_width_m:
            measured = _measure(box, returns, replace(rule, outside_m=0.0), below_m)
        if measured is not None:
            # The same object's other detections are moved first, because they need its former center.
            same = _same_object_other_label(detections, int(i)) & ~is_measurable
            center[same, :2] += measured.center_xy + foot - center[i, :2]
            center[i, :2], size[i, :2], yaw[i] = measured.center_xy + foot, measured.sides, measured.yaw
    return replace(detections, center=center, size=size, yaw=yaw)


def _same_object_other_label(detections: Detections, i: int) -> NDArray[np.bool_]:
    """Return (n,): True for detections with another label at the position of detection `i`.

    They are moved together. Otherwise a cone with a second, weak detection as an animal would become a cone and an
    animal next to it. Pedestrians are not moved, because they stand close to objects.
    """
    distance = np.hypot(*(detections.center[:, :2] - detections.center[i, :2]).T)
    has_other_label = (detections.label != detections.label[i]) & (detections.label != PERSON)
    return np.asarray((distance < SAME_POSITION_M) & has_other_label)


@dataclass(frozen=True, eq=False)
class _Returns:
    """Returns from objects and from the ground, around the LiDAR's foot."""

    positions: Floats
    """(n, 2): positions (m)."""
    distance: Floats
    """(n,): distances (m)."""
    azimuth: Floats
    """(n,): directions (rad)."""
    above: Floats
    """(n,): heights above the ground (m)."""
    lidar_height_m: float
    """Height of the LiDAR (m)."""
    column_rad: float
    """Angle between two columns of its rays (rad)."""

    @staticmethod
    def near(points: NDArray[np.floating], lidar: LidarRig) -> _Returns:
        """Return the returns of the last sweeps (n, 3 or more) that matter here."""
        x, y, z = (np.asarray(points[:, axis], np.float64) for axis in range(3))
        x, y = x - lidar.mount.x_m, y - lidar.mount.y_m
        distance, azimuth = np.hypot(x, y), np.arctan2(y, x)
        above = z - ground_heights(azimuth, distance, z)
        usable = (above < OVERHEAD_M) & (distance < 2.0 * NEAR_M)
        columns = lidar.points_per_s / (lidar.channels * lidar.turns_per_s)
        positions = np.column_stack([x, y])
        polar = (distance[usable], azimuth[usable], above[usable])
        return _Returns(positions[usable], *polar, lidar.mount.z_m, math.tau / columns)

    def part(self, mask: NDArray[np.bool_]) -> _Returns:
        """Return some of the returns; the mask is (n,)."""
        columns = self.positions[mask], self.distance[mask], self.azimuth[mask], self.above[mask]
        return _Returns(*columns, self.lidar_height_m, self.column_rad)


class _Box:
    """A rectangle around the LiDAR's foot: center, sides (length, width) (m) and direction (rad)."""

    def __init__(self, center_xy: Floats, sides: Floats, yaw: float) -> None:
        self.center_xy, self.sides, self.yaw = center_xy, sides, yaw
        self.axes = _axes(yaw)

    def contains(self, positions: Floats, margin_m: float) -> NDArray[np.bool_]:
        """Return (n,): True for positions (n, 2) in the box with a margin (m)."""
        return np.asarray((np.abs((positions - self.center_xy) @ self.axes.T) < self.sides / 2 + margin_m).all(axis=1))

    def corners(self) -> Floats:
        """Return (4, 2): the corners (m)."""
        signs = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)])
        return np.asarray(self.center_xy + (signs * self.sides / 2) @ self.axes)

    def chord(self, azimuth: float) -> tuple[float, float] | None:
        """Return the distances at which a ray from the LiDAR's foot enters and leaves the box (m); None if it does
        not.
        """
        along = self.axes @ np.array([math.cos(azimuth), math.sin(azimuth)])
        # A ray parallel to a side never crosses it, so that the division below requires a small angle.
        along = np.where(np.abs(along) < 1e-9, 1e-9, along)
        start = -self.axes @ self.center_xy
        first, second = (-self.sides / 2 - start) / along, (self.sides / 2 - start) / along
        enters, leaves = max(float(np.minimum(first, second).max()), 0.0), float(np.maximum(first, second).min())
        return (enters, leaves) if leaves > enters else None


def _axes(yaw: float) -> Floats:
    """Return (2, 2): unit vectors along and across a direction (rad)."""
    return np.array([(math.cos(yaw), math.sin(yaw)), (-math.sin(yaw), math.cos(yaw))])


def _measure(box: _Box, returns: _Returns, rule: MeasuringRule, below_m: float) -> _Box | None:
    """Return the part of a box that may be occupied, as a box; None with too few returns."""
    bearing = math.atan2(box.center_xy[1], box.center_xy[0])
    corners = box.corners()
    edges = _relative_azimuth(np.arctan2(corners[:, 1], corners[:, 0]), bearing)
    max_angle = np.abs(edges).max() + math.atan2(rule.outside_m, np.hypot(*box.center_xy)) + SECTOR_RAD
    returns = returns.part(np.abs(_relative_azimuth(returns.azimuth, bearing)) < max_angle)
    hit = (returns.above > rule.min_height_m) & box.contains(returns.positions, rule.outside_m)
    if hit.sum() < rule.min_returns:
        return None
    relative = _relative_azimuth(returns.azimuth, bearing)
    sector = np.floor(relative / SECTOR_RAD).astype(np.int64)
    first, last = min(edges.min(), relative[hit].min()), max(edges.max(), relative[hit].max())
    occupied = [returns.positions[hit]]
    for k in range(math.floor(first / SECTOR_RAD), math.ceil(last / SECTOR_RAD)):
        angles, nearest_m = _occupied_part(box, k, returns, relative, sector == k, hit, below_m, rule.min_beyond)
        for angle in angles:
            chord = box.chord(bearing + angle)
            start_m = chord[0] if nearest_m is None and chord is not None else nearest_m
            if start_m is None:
                continue
            # The returns do not show the depth of a large object, so the network's depth is used.
            end_m = chord[1] if chord is not None and rule.min_beyond else start_m
            reach = np.array([start_m, end_m if nearest_m is None else max(end_m, start_m + MIN_DEPTH_M)])
            occupied.append(reach[:, None] * (math.cos(bearing + angle), math.sin(bearing + angle)))
    direction = _edge_direction(returns.positions[hit]) if rule.uses_edges else bearing
    bounds = _bounding_box(np.concatenate(occupied), direction, box.yaw)
    return _Box(bounds.center_xy, np.maximum(bounds.sides, rule.min_width_m), bounds.yaw)


def _relative_azimuth(azimuth: Floats, bearing: float) -> Floats:
    """Return directions relative to another one (rad, -pi to pi)."""
    return np.asarray(np.remainder(azimuth - bearing + math.pi, math.tau) - math.pi)


def _occupied_part(
    box: _Box,
    k: int,
    returns: _Returns,
    relative: Floats,
    in_sector: NDArray[np.bool_],
    hit: NDArray[np.bool_],
    below_m: float,
    min_beyond: int,
) -> tuple[list[float], float | None]:
    """Return the directions in sector `k` that bound the occupied part (rad), and its distance (m).

    `in_sector` (n,) marks the returns of the sector, and `hit` (n,) those of the object. The distance is None if the
    sector has no return from the object.
    """
    first, last = k * SECTOR_RAD, (k + 1) * SECTOR_RAD
    own_returns = in_sector & hit
    bearing = math.atan2(box.center_xy[1], box.center_xy[0])
    chords = [box.chord(bearing + angle) for angle in (first, (first + last) / 2, last)]
    nearest_m = float(returns.distance[own_returns].min()) if own_returns.any() else None
    starts = [chord[0] for chord in chords if chord is not None] + ([] if nearest_m is None else [nearest_m])
    if not starts:
        return [], None
    start_m = min(starts)
    beyond = in_sector & ~hit & (returns.distance > start_m + FRONT_MARGIN_M)
    # The height of the ray at the object: it descends linearly from the LiDAR to its return.
    lidar_height_m = returns.lidar_height_m
    height = lidar_height_m + (returns.above - lidar_height_m) * start_m / np.maximum(returns.distance, EDGE_M)
    beyond &= height < below_m
    if nearest_m is None:
        return ([], None) if beyond.sum() >= min_beyond else ([first, (first + last) / 2, last], None)
    low, high = float(relative[own_returns].min()), float(relative[own_returns].max())
    # Rays that passed next to the outermost return prove that the object ends before the next column.
    low = max(low - returns.column_rad, first) if (beyond & (relative < low)).sum() >= min_beyond else first
    high = min(high + returns.column_rad, last) if (beyond & (relative > high)).sum() >= min_beyond else last
    return [low, high], nearest_m - FRONT_MARGIN_M


def _edge_direction(positions: Floats) -> float:
    """Return the direction of the rectangle with most of the positions (n, 2) near its edges, from 0 to pi/2 (rad)."""
    angles = np.arange(0.0, math.pi / 2, STEP_RAD)
    cos, sin = np.cos(angles)[:, None], np.sin(angles)[:, None]
    x, y = positions.T
    first, second = cos * x + sin * y, cos * y - sin * x
    distance = np.minimum(_distance_to_edge(first), _distance_to_edge(second))
    return float(angles[(1.0 / np.maximum(distance, EDGE_M)).sum(axis=1).argmax()])


def _distance_to_edge(along: Floats) -> Floats:
    """Return (angles, n): the distance of each position from the nearer end of all positions (m)."""
    result: Floats = np.minimum(along - along.min(axis=1, keepdims=True), along.max(axis=1, keepdims=True) - along)
    return result


def _bounding_box(positions: Floats, direction: float, length_yaw: float) -> _Box:
    """Return the box around positions (n, 2) in a direction. Its length is the side nearest to `length_yaw`."""
    yaw = direction + round((length_yaw - direction) / (math.pi / 2)) * (math.pi / 2)
    axes = _axes(yaw)
    along = positions @ axes.T
    low, high = along.min(axis=0), along.max(axis=0)
    return _Box((low + high) / 2 @ axes, high - low, yaw)
