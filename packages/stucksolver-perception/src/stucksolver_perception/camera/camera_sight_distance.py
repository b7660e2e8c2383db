"""Computes the sight distance of the camera: the length of a lane in which it would have detected a vehicle.

The shortest of three limits counts:

* the detector's recall, measured on held-out images of the same brightness and contrast;
* the image: its edges, and vehicles in front that cover the lane;
* the road: beyond a bend or a crest, houses and hills may be in between, which the camera does not report. So a line of
  sight counts only while it stays above the road's surface, where there are no buildings.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.camera.crops import corners_of
from stucksolver_perception.camera.far_lane_placement import resampled
from stucksolver_perception.measurements import Floats
from stucksolver_perception.rig import CameraRig

REQUIRED_PROB = 0.95
"""Probability with which a vehicle must have been detected. Ours."""
BOUND_Z = 1.0
"""Number of standard deviations of Wilson's interval, whose lower end is the recall (84 % one-sided). Ours."""
LOOK_SPACING_S = 0.5
"""Minimum time between two looks that both count (s). The share of repeated misses was measured at this spacing."""
MAX_LOOKS = 3
"""Maximum number of looks that count. A vehicle missed three times (unlit, at night) will be missed again. Ours."""
STEP_M = 2.5
"""Distance between the examined points of a lane (m). Ours."""
NEAR_M = 25.0
"""Distance from which the detector's recall counts (m). The LiDAR covers the sight up to it. Ours."""
SIDES_M = (-0.7, 0.0, 0.7)
"""Lateral positions of a car's points relative to the lane's center (m). Ours."""
UPPER_M = (1.0, 1.2)
"""Heights of these points above the road (m); all points must be uncovered. Ours."""
LOW_M = 0.4
"""Height of the points for partly visible vehicles (m). If one of them is covered, for example by the roof of a stopped
car close ahead, the recall for such vehicles applies. Ours."""
CORRIDOR_M = 7.0
"""Maximum distance of a line of sight from the lane's center (m): over a two-lane road. Ours."""
EYE_CLEARANCE_M = 0.2
"""Minimum height of a line of sight above the road's crests (m). Ours."""
MARGIN_PX = 6.0
"""Margin at the image's edges (px). Ours."""
NEAREST_M = 0.5
"""Minimum distance from the lens of a corner that can be projected (m). Ours."""


@dataclass(frozen=True)
class SightModel:
    """Reliability of the detector. It was measured in training, and is stored in the network's card."""

    bins_m: tuple[float, ...]
    brightness: tuple[float, ...]
    contrast: tuple[float, ...]
    """Edges between the classes of images (see `horizon_strip.look_of`)."""
    miss: Floats
    """(classes, bins): upper bound of the share of vehicles missed in one look."""
    again: float
    """Upper bound of the share of missed vehicles that a second look also misses."""
    miss_part: Floats | None = None
    """The same as `miss` for vehicles that are partly covered; None if these count as missed."""
    again_part: float = 1.0
    """The same as `again` for vehicles that are partly covered."""

    @staticmethod
    def from_card(card: Mapping[str, Any], label: str = "vehicle") -> SightModel:
        """Read the model from a network's card, for one label of `horizon_strip.LABELS`."""
        edges, part = card["look_edges"], card.get("part")
        return SightModel(
            tuple(float(item) for item in card["bins_m"]),
            tuple(float(edge) for edge in edges["brightness"]),
            tuple(float(edge) for edge in edges["contrast"]),
            _miss_bounds(card["recall"][label]),
            _again_bound(card["repeated_miss"]),
            None if part is None else _miss_bounds(part["recall"]),
            1.0 if part is None else _again_bound(part["repeated_miss"]),
        )

    def miss_at(self, range_m: Floats, look: Floats, part: NDArray[np.bool_] | bool = False) -> Floats:
        """Return the upper bound of the share missed in one look at these ranges; 1 beyond the measured ranges.

        `part`: True where a nearer object covers a part of a vehicle.
        """
        look_class = int(np.searchsorted(self.brightness, look[0])) * (len(self.contrast) + 1)
        look_class += int(np.searchsorted(self.contrast, look[1]))
        bin_index = np.digitize(range_m, self.bins_m) - 1
        is_known = (bin_index >= 0) & (bin_index < self.miss.shape[1])
        bin_index = np.clip(bin_index, 0, self.miss.shape[1] - 1)
        of_part = np.ones_like(range_m) if self.miss_part is None else self.miss_part[look_class, bin_index]
        miss = np.where(part, of_part, self.miss[look_class, bin_index])
        return np.where(range_m < NEAR_M, 0.0, np.where(is_known, miss, 1.0))

    def reach_m(self, look: Floats, looks: int = 1) -> float:
        """Return the range up to which the detector is reliable on an open straight road (m)."""
        distance_m = np.arange(0.0, self.bins_m[-1], 1.0)
        is_missed = self.miss_at(distance_m, look) * self.again ** (min(looks, MAX_LOOKS) - 1) > 1.0 - REQUIRED_PROB
        return float(distance_m[is_missed][0]) if is_missed.any() else self.bins_m[-1]


@dataclass(frozen=True, eq=False)
class LaneCoverage:
    """The part of a lane in one image. The caller stores it, to combine it with later ones."""

    time_s: float
    visible_m: float
    """Length of the line from its start to the first point that is covered, bends away or leaves the image (m)."""
    look: Floats
    """Brightness and contrast of the image; see `horizon_strip.look_of`."""
    whole_m: float = math.inf
    """Length up to which a whole vehicle would be visible (m). Beyond it, a nearer object may cover its lower part."""

    def moved(self, meters: float) -> LaneCoverage:
        """Return the coverage after the line's start has moved forward by some meters."""
        visible_m, whole_m = max(self.visible_m - meters, 0.0), max(self.whole_m - meters, 0.0)
        return replace(self, visible_m=visible_m, whole_m=whole_m)


class CameraSight:
    """Sight distances of a camera whose images a `FarDetector` examines."""

    def __init__(self, rig: CameraRig, model: SightModel) -> None:
        self._rig, self._model = rig, model

    def look(self, time_s: float, look: Floats, line: Floats, blockers: Floats) -> LaneCoverage:
        """Return the part of a lane in an image.

        Args:
            time_s: Time of the image (s).
            look: `FarDetections.look`.
            line: The lane's center (k, 2) or (k, 3) in the vehicle frame, from the start of the required sight.
            blockers: (n, 7) boxes of all known objects in the vehicle frame: center, size, yaw.
        """
        points, along = resampled(line, STEP_M)
        if not len(along):
            return LaneCoverage(time_s, 0.0, look)
        low, *upper = self._covered(points, blockers, (LOW_M, *UPPER_M))
        is_visible = self._is_in_image(points) & ~np.any(upper, axis=0) & self._is_over_road(points)
        # The image does not contain points next to or behind the lens. Sight starts at the first point ahead.
        ahead = self._rig.project(points)[2] > NEAR_M
        ends = np.flatnonzero(~is_visible & ahead)
        visible = float(along[ends[0]] if len(ends) else along[-1]) if ahead.any() else 0.0
        part = np.flatnonzero(low & ahead)
        return LaneCoverage(time_s, visible, look, float(along[part[0]]) if len(part) else math.inf)

    def visible_length_m(self, line: Floats, now: LaneCoverage, earlier: Sequence[LaneCoverage] = ()) -> float:
        """Return the length of the lane, from its start, in which a vehicle would have been detected until now (m).

        Misses of two looks often have a common cause. So an additional look counts with the measured share of repeated
        misses, never as independent, and only up to `MAX_LOOKS`.

        Args:
            line: As in `look`.
            now: The latest look.
            earlier: Earlier looks at the same lane, each `moved` to the present start of the line.
        """
        points, along = resampled(line, STEP_M)
        distance_m = np.hypot(points[:, 0] - self._rig.mount.x_m, points[:, 1] - self._rig.mount.y_m)
        part = along >= now.whole_m
        missed = self._model.miss_at(distance_m, now.look, part)
        again, of_part = self._model.again, max(self._model.again, self._model.again_part)
        extra_looks, last_s = np.zeros(len(along)), now.time_s
        for item in sorted(earlier, key=lambda look: -look.time_s):
            # An earlier look with a worse view than the present one does not count.
            if last_s - item.time_s >= LOOK_SPACING_S and self._is_as_reliable(item, now):
                is_counted = (item.visible_m >= along) & (extra_looks < MAX_LOOKS - 1)
                missed = missed * np.where(is_counted, np.where(part | (along >= item.whole_m), of_part, again), 1.0)
                extra_looks += is_counted
                last_s = item.time_s
        is_missed = (missed > 1.0 - REQUIRED_PROB) | (along > now.visible_m)
        return float(along[is_missed][0]) if is_missed.any() else float(along[-1]) if len(along) else 0.0

    def _is_as_reliable(self, coverage: LaneCoverage, now: LaneCoverage) -> bool:
        return self._model.reach_m(coverage.look) >= self._model.reach_m(now.look)

    def _is_in_image(self, points: Floats) -> NDArray[np.bool_]:
        column, row, ahead = self._rig.project(points)
        width, height = self._rig.width_px, self._rig.height_px
        is_across = (column > MARGIN_PX) & (column < width - MARGIN_PX)
        return np.asarray((ahead > 0.0) & is_across & (row > MARGIN_PX) & (row < height - MARGIN_PX))

    def _covered(self, points: Floats, blockers: Floats, heights_m: Sequence[float]) -> NDArray[np.bool_]:
        """Return (heights, m): True if a nearer object covers a car at the point, at this height above the road (m)."""
        covered = np.zeros((len(heights_m), len(points)), bool)
        if not len(blockers):
            return covered
        column, row, ahead = (item.reshape(-1, 8) for item in self._rig.project(corners_of(blockers).reshape(-1, 3)))
        before = ahead.max(axis=1) > NEAREST_M
        # Corners next to or behind the lens cannot be projected. They are moved beyond the image's edge on their side.
        edge = np.where(np.sign(corners_of(blockers)[..., 1]) > 0, -1e6, 1e6)
        column = np.where(ahead > NEAREST_M, column, edge)
        row = np.where(ahead > NEAREST_M, row, 1e6)
        # A box that starts next to the lens covers everything behind it, up to the image's upper edge.
        top = np.where((ahead > NEAREST_M).all(axis=1), row.min(axis=1), -1e6)
        course = np.gradient(points[:, :2], axis=0) if len(points) > 1 else np.array([[1.0, 0.0]])
        course /= np.maximum(np.hypot(course[:, 0], course[:, 1]), 1e-9)[:, None]
        for side, (k, up) in product(SIDES_M, enumerate(heights_m)):
            points_at = points + np.column_stack([-side * course[:, 1], side * course[:, 0], np.full(len(points), up)])
            x, y, far = self._rig.project(points_at)
            is_inside = (x[:, None] > column.min(1)) & (x[:, None] < column.max(1)) & before
            is_inside &= (y[:, None] > top) & (y[:, None] < row.max(1))
            covered[k] |= (is_inside & (ahead.min(axis=1) < far[:, None])).any(axis=1)
        return covered

    def _is_over_road(self, points: Floats) -> NDArray[np.bool_]:
        """Return (m,): True if the line of sight to the point stays above the road along the points."""
        mount = self._rig.mount
        eye = np.array([mount.x_m, mount.y_m, mount.z_m])
        rays = points + np.array([0.0, 0.0, UPPER_M[-1]]) - eye
        square = np.maximum(np.sum(rays[:, :2] ** 2, axis=1), 1e-9)
        # Axes: (target point, road point before it). The value is the second point's position along the line of sight.
        share = np.clip(rays[:, :2] @ (points[:, :2] - eye[:2]).T / square[:, None], 0.0, 1.0)
        on_ray = eye + share[..., None] * rays[:, None]
        is_outside = np.hypot(*np.moveaxis(points[None, :, :2] - on_ray[..., :2], 2, 0)) > CORRIDOR_M
        below = (on_ray[..., 2] < points[None, :, 2] + EYE_CLEARANCE_M) & (share > 0.0) & (share < 1.0)
        front = points[:, 0] > mount.x_m
        before = np.tri(len(points), k=-1, dtype=bool) & front[None]
        is_near = ~front | (np.hypot(points[:, 0], points[:, 1]) <= NEAR_M)
        return np.asarray(is_near | ~((is_outside | below) & before).any(axis=1))


def _miss_bounds(is_counted: Sequence[Sequence[Sequence[int]]]) -> Floats:
    """Return the upper bounds of the missed share, from pairs of detected and all vehicles."""
    hits = np.array(is_counted, np.float64)
    return np.asarray(1.0 - wilson_lower(hits[..., 0], hits[..., 1]))


def _again_bound(is_counted: Sequence[int]) -> float:
    """Return the upper bound of the share missed again, from the counts of vehicles missed twice and missed once."""
    twice, once = is_counted
    return float(1.0 - wilson_lower(np.array(float(once - twice)), np.array(float(once))))


def wilson_lower(hits: Floats, total: Floats) -> Floats:
    """Return the lower end of a share's interval (Wilson 1927) with `BOUND_Z` standard deviations; 0 without data."""
    n = np.maximum(total, 1e-9)
    share, square = hits / n, BOUND_Z**2
    center = share + square / (2.0 * n)
    spread = BOUND_Z * np.sqrt(share * (1.0 - share) / n + square / (4.0 * n**2))
    return np.where(total > 0, np.maximum((center - spread) / (1.0 + square / n), 0.0), 0.0)
