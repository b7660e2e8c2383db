"""How far along a lane the camera would have detected a vehicle: the part of the lane that may count as free.

Three things end the sight, whichever comes first:

* the detector's recall, measured on held-out images of the same brightness and contrast;
* the image: its edges, and vehicles in front that cover the lane;
* the road: beyond a bend or a crest, houses and hills may stand in between, which the camera does not report. So a line
  of sight counts only while it stays above the road's own surface, where nothing is built.
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

REQUIRED = 0.95
"""A vehicle must have been detected with this probability."""
BOUND_Z = 1.0
"""Recall is the lower end of Wilson's interval with this many standard deviations (84 % one-sided)."""
LOOK_APART_S = 0.5
"""Looks closer in time count as one; the share of repeated misses was measured at this distance."""
MOST_LOOKS = 3
"""More looks add nothing: a vehicle missed three times (an unlit car at night) will be missed again."""
STEP_M = 2.5
"""Distance between the examined places of a lane."""
NEAR_M = 25.0
"""Up to here sight is the LiDAR's task; the detector's recall counts from here on."""
SIDES_M = (-0.7, 0.0, 0.7)
"""Points of a car beside the lane's center (m)."""
UPPER_M = (1.0, 1.2)
"""Their heights above the road (m); all must be uncovered."""
LOW_M = 0.4
"""If one at this height (m) is covered, as by the roof of a car that stands close ahead, the recall for vehicles seen
in part applies.
"""
CORRIDOR_M = 7.0
"""A line of sight stays over a two-lane road within this distance of the lane's center."""
EYE_CLEARANCE_M = 0.2
"""A line of sight passes at least this far above the road's crests."""
MARGIN_PX = 6.0
"""Margin at the image's edges."""
BEHIND_M = 0.5


@dataclass(frozen=True)
class SightModel:
    """How reliably the detector finds vehicles; measured in training, stored in the network's card."""

    bins_m: tuple[float, ...]
    brightness: tuple[float, ...]
    contrast: tuple[float, ...]
    """Edges between classes of look (see `far_strip.look_of`)."""
    miss: Floats
    """(classes of look, bins): upper bound of the share missed in one look."""
    again: float
    """Upper bound of the share of missed vehicles that a second look also misses."""
    miss_part: Floats | None = None
    """The same as `miss` for vehicles of which something nearer covers a part; None: these count as missed."""
    again_part: float = 1.0

    @staticmethod
    def from_card(card: Mapping[str, Any], label: str = "vehicle") -> SightModel:
        """Read the model from a network's card, for one label of `far_strip.LABELS`."""
        edges, part = card["look_edges"], card.get("part")
        return SightModel(
            tuple(float(item) for item in card["bins_m"]),
            tuple(float(edge) for edge in edges["brightness"]),
            tuple(float(edge) for edge in edges["contrast"]),
            _missed(card["recall"][label]),
            _again(card["repeated_miss"]),
            None if part is None else _missed(part["recall"]),
            1.0 if part is None else _again(part["repeated_miss"]),
        )

    def miss_at(self, range_m: Floats, look: Floats, part: NDArray[np.bool_] | bool = False) -> Floats:
        """Return the upper bound of the share missed in one look at these ranges; 1 beyond the measured ranges.

        `part`: whether something nearer covers a part of a vehicle there.
        """
        sort = int(np.searchsorted(self.brightness, look[0])) * (len(self.contrast) + 1)
        sort += int(np.searchsorted(self.contrast, look[1]))
        place = np.digitize(range_m, self.bins_m) - 1
        known = (place >= 0) & (place < self.miss.shape[1])
        place = np.clip(place, 0, self.miss.shape[1] - 1)
        of_part = np.ones_like(range_m) if self.miss_part is None else self.miss_part[sort, place]
        told = np.where(part, of_part, self.miss[sort, place])
        return np.where(range_m < NEAR_M, 0.0, np.where(known, told, 1.0))

    def reach_m(self, look: Floats, looks: int = 1) -> float:
        """Return how far the detector is reliable on an open straight road (m)."""
        away = np.arange(0.0, self.bins_m[-1], 1.0)
        fails = self.miss_at(away, look) * self.again ** (min(looks, MOST_LOOKS) - 1) > 1.0 - REQUIRED
        return float(away[fails][0]) if fails.any() else self.bins_m[-1]


@dataclass(frozen=True, eq=False)
class LaneCoverage:
    """How much of a lane one image shows; the caller keeps it to combine it with later ones."""

    time_s: float
    visible_m: float
    """Distance along the lane's line from its start to where it is first covered, bends away or leaves the image."""
    look: Floats
    """The image's look, see `far_strip.look_of`."""
    whole_m: float = math.inf
    """Distance up to which a whole vehicle would be seen; beyond, something nearer may cover its lower part."""

    def moved(self, metres: float) -> LaneCoverage:
        """The same after the line's start has moved on by some meters."""
        visible_m, whole_m = max(self.visible_m - metres, 0.0), max(self.whole_m - metres, 0.0)
        return replace(self, visible_m=visible_m, whole_m=whole_m)


class CameraSight:
    """Sight along lanes with a camera whose images a `FarDetector` examines."""

    def __init__(self, rig: CameraRig, model: SightModel) -> None:
        self._rig, self._model = rig, model

    def look(self, time_s: float, look: Floats, line: Floats, blockers: Floats) -> LaneCoverage:
        """Return how much of a lane an image shows.

        Args:
            time_s: Time of the image (s).
            look: `FarDetections.look`.
            line: The lane's center (k, 2) or (k, 3) in the vehicle frame, from where sight is needed.
            blockers: (n, 7) boxes of everything known to be around, in the vehicle frame: center, size, yaw.
        """
        points, along = resampled(line, STEP_M)
        if not len(along):
            return LaneCoverage(time_s, 0.0, look)
        low, *upper = self._covered(points, blockers, (LOW_M, *UPPER_M))
        fine = self._in_picture(points) & ~np.any(upper, axis=0) & self._over_road(points)
        # The camera does not see beside or behind the lens; sight begins at the first place ahead.
        ahead = self._rig.project(points)[2] > NEAR_M
        ends = np.flatnonzero(~fine & ahead)
        visible = float(along[ends[0]] if len(ends) else along[-1]) if ahead.any() else 0.0
        part = np.flatnonzero(low & ahead)
        return LaneCoverage(time_s, visible, look, float(along[part[0]]) if len(part) else math.inf)

    def visible_length_m(self, line: Floats, now: LaneCoverage, earlier: Sequence[LaneCoverage] = ()) -> float:
        """Return the meters of the lane, from its start, in which a vehicle would have been detected by now.

        Misses of two looks often have a common cause. So a further look counts with the measured share of repeated
        misses, never as independent, and only up to `MOST_LOOKS`.

        Args:
            line: As given to `look`.
            now: The latest look.
            earlier: Earlier looks at the same lane, each `moved` to the present start of the line.
        """
        points, along = resampled(line, STEP_M)
        away = np.hypot(points[:, 0] - self._rig.mount.x_m, points[:, 1] - self._rig.mount.y_m)
        part = along >= now.whole_m
        missed = self._model.miss_at(away, now.look, part)
        again, of_part = self._model.again, max(self._model.again, self._model.again_part)
        further, last_s = np.zeros(len(along)), now.time_s
        for item in sorted(earlier, key=lambda look: -look.time_s):
            # A worse view than in the present look is handled by not counting it.
            if last_s - item.time_s >= LOOK_APART_S and self._as_sharp(item, now):
                counts = (item.visible_m >= along) & (further < MOST_LOOKS - 1)
                missed = missed * np.where(counts, np.where(part | (along >= item.whole_m), of_part, again), 1.0)
                further += counts
                last_s = item.time_s
        fails = (missed > 1.0 - REQUIRED) | (along > now.visible_m)
        return float(along[fails][0]) if fails.any() else float(along[-1]) if len(along) else 0.0

    def _as_sharp(self, coverage: LaneCoverage, now: LaneCoverage) -> bool:
        return self._model.reach_m(coverage.look) >= self._model.reach_m(now.look)

    def _in_picture(self, points: Floats) -> NDArray[np.bool_]:
        column, row, ahead = self._rig.project(points)
        wide, high = self._rig.width_px, self._rig.height_px
        across = (column > MARGIN_PX) & (column < wide - MARGIN_PX)
        return np.asarray((ahead > 0.0) & across & (row > MARGIN_PX) & (row < high - MARGIN_PX))

    def _covered(self, points: Floats, blockers: Floats, heights_m: Sequence[float]) -> NDArray[np.bool_]:
        """(heights, m): True if something nearer hides a car at the point at this height above the road (m)."""
        covered = np.zeros((len(heights_m), len(points)), bool)
        if not len(blockers):
            return covered
        column, row, ahead = (item.reshape(-1, 8) for item in self._rig.project(corners_of(blockers).reshape(-1, 3)))
        before = ahead.max(axis=1) > BEHIND_M
        # Corners beside the lens are moved to the image's edge on their side.
        edge = np.where(np.sign(corners_of(blockers)[..., 1]) > 0, -1e6, 1e6)
        column = np.where(ahead > BEHIND_M, column, edge)
        row = np.where(ahead > BEHIND_M, row, 1e6)
        # A box that begins beside the lens hides everything behind it up to the image's upper edge.
        top = np.where((ahead > BEHIND_M).all(axis=1), row.min(axis=1), -1e6)
        course = np.gradient(points[:, :2], axis=0) if len(points) > 1 else np.array([[1.0, 0.0]])
        course /= np.maximum(np.hypot(course[:, 0], course[:, 1]), 1e-9)[:, None]
        for side, (k, up) in product(SIDES_M, enumerate(heights_m)):
            body = points + np.column_stack([-side * course[:, 1], side * course[:, 0], np.full(len(points), up)])
            x, y, far = self._rig.project(body)
            inside = (x[:, None] > column.min(1)) & (x[:, None] < column.max(1)) & before
            inside &= (y[:, None] > top) & (y[:, None] < row.max(1))
            covered[k] |= (inside & (ahead.min(axis=1) < far[:, None])).any(axis=1)
        return covered

    def _over_road(self, points: Floats) -> NDArray[np.bool_]:
        """(m,): True if the line of sight to the point stays above the road, whose course the points are."""
        mount = self._rig.mount
        eye = np.array([mount.x_m, mount.y_m, mount.z_m])
        to = points + np.array([0.0, 0.0, UPPER_M[-1]]) - eye
        square = np.maximum(np.sum(to[:, :2] ** 2, axis=1), 1e-9)
        # (seen point, road point before it): distance of the second along the line of sight.
        share = np.clip(to[:, :2] @ (points[:, :2] - eye[:2]).T / square[:, None], 0.0, 1.0)
        on_ray = eye + share[..., None] * to[:, None]
        beside = np.hypot(*np.moveaxis(points[None, :, :2] - on_ray[..., :2], 2, 0)) > CORRIDOR_M
        below = (on_ray[..., 2] < points[None, :, 2] + EYE_CLEARANCE_M) & (share > 0.0) & (share < 1.0)
        front = points[:, 0] > mount.x_m
        before = np.tri(len(points), k=-1, dtype=bool) & front[None]
        near = ~front | (np.hypot(points[:, 0], points[:, 1]) <= NEAR_M)
        return np.asarray(near | ~((beside | below) & before).any(axis=1))


def _missed(counts: Sequence[Sequence[Sequence[int]]]) -> Floats:
    """Return the upper bounds of the missed share, from pairs of found and all."""
    found = np.array(counts, np.float64)
    return np.asarray(1.0 - wilson_lower(found[..., 0], found[..., 1]))


def _again(counts: Sequence[int]) -> float:
    """Return the upper bound of the share missed again, from those missed twice and those missed in the first look."""
    twice, once = counts
    return float(1.0 - wilson_lower(np.array(float(once - twice)), np.array(float(once))))


def wilson_lower(hits: Floats, total: Floats) -> Floats:
    """Return the lower end of the interval of a share (Wilson 1927), `BOUND_Z` standard deviations; 0 without data."""
    n = np.maximum(total, 1e-9)
    share, square = hits / n, BOUND_Z**2
    middle = share + square / (2.0 * n)
    spread = BOUND_Z * np.sqrt(share * (1.0 - share) / n + square / (4.0 * n**2))
    return np.where(total > 0, np.maximum((middle - spread) / (1.0 + square / n), 0.0), 0.0)
