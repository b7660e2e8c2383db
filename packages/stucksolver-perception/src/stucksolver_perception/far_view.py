"""What the last images showed far ahead, and how far along a lane they prove that nobody comes.

Assumptions, besides those of `camera/far_sight.py`:

* The road is flat: lanes come without heights. Behind a crest the detector's own recall covers what is not seen.
* A detected vehicle hides what is behind it, even if nobody tracks it yet. It is assumed to be as near as two standard
  deviations of its range allow.
* A vehicle that was not in the image drives on until now: the seen length is reduced by that distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stucksolver_perception.camera.camera_sight_distance import (
    LOOK_SPACING_S,
    MAX_LOOKS,
    NEAR_M,
    REQUIRED_PROB,
    CameraSight,
    LaneCoverage,
    SightModel,
)
from stucksolver_perception.camera.far_detector import FarDetections
from stucksolver_perception.camera.far_range import FarPlaces
from stucksolver_perception.measurements import Floats, PoseEstimate
from stucksolver_perception.rig import CameraRig
from stucksolver_perception.tracking import Track, boxes_of
from stucksolver_perception.vehicle_frame import points_into_vehicle

FRESH_S = 0.45
"""An older image says nothing about now: two images have failed to come."""
KEPT_S = LOOK_SPACING_S * MAX_LOOKS
"""Older looks cannot count."""
SURE_SDS = 2.0
STEP_M = 5.0
"""Distance between the ranges at which the detector's recall is looked up; its bins are 25 m wide."""
DEPTH_M, HIGH_M = 2.0, 1.5
"""Smallest length and height by which a detection hides the area behind it."""


@dataclass(frozen=True, eq=False)
class FarImage:
    """One image with its detections."""

    found: FarDetections
    pose: PoseEstimate
    """At the time of the image."""
    blockers: Floats
    """(n, 7): boxes of everything known to be around then, in the vehicle frame at `pose`."""


@dataclass(frozen=True, eq=False)
class FarView:
    """The looks of the last images, the newest first."""

    looks: tuple[FarImage, ...]
    sight: CameraSight
    model: SightModel
    """The same model as in `sight`."""

    def with_look(self, look: FarImage) -> FarView:
        """Add a later image; of the others those are kept that can still count."""
        kept = (item for item in self.looks if look.found.time_s - item.found.time_s <= KEPT_S)
        return replace(self, looks=(look, *kept))

    def clear_length_m(self, line: Floats, from_m: float, fastest_mps: float, now_s: float) -> float:
        """Return the meters of a lane, from its start, in which nobody is: up to `from_m` by another sensor, then by
        the camera.

        Args:
            line: The lane's center (k, 2), local frame, from beside the ego on.
            from_m: How much of it another sensor saw (m). The camera continues from there, and only if that is beyond
                the range from which its recall was measured.
            fastest_mps: Highest speed of vehicles in the lane (m/s).
            now_s: The time of the question (s).
        """
        if not self.looks or len(line) < 2:
            return from_m
        newest = self.looks[0]
        age_s = now_s - newest.found.time_s
        rest = _rest(line, from_m)
        if age_s > FRESH_S or len(rest) < 2:
            return from_m
        begins = points_into_vehicle(rest[:1], newest.pose)[0]
        away_m = float(np.hypot(*begins))
        most_m = self._reach_m(newest.found.look, away_m) - away_m
        if away_m < NEAR_M or begins[0] < 0.0 or most_m <= 0.0:
            return from_m
        # A lane is nowhere shorter than the line of sight, but may be longer by a bend. What hides the part that the
        # other sensor saw does not matter: the roof of a car ahead may hide the road up to there, and not beyond.
        rest = _first(rest, 2.0 * most_m)
        shown = [self._shown(item, rest) for item in self._apart()]
        # A vehicle that has entered an earlier image's view since was not in it; see the module's text.
        gone = [item.moved(fastest_mps * (newest.found.time_s - item.time_s)) for item in shown]
        seen = self.sight.visible_length_m(points_into_vehicle(rest, newest.pose), gone[0], gone[1:])
        return from_m + max(seen - fastest_mps * max(age_s, 0.0), 0.0)

    def _reach_m(self, look: Floats, from_m: float) -> float:
        """Return the range up to which the detector can be reliable in such images (m); at least from `from_m` on."""
        away = np.arange(from_m, self.model.bins_m[-1] + STEP_M, STEP_M)
        missed = self.model.miss_at(away, look) * self.model.again ** (MAX_LOOKS - 1)
        fails = missed > 1.0 - REQUIRED_PROB
        return float(away[fails][0]) if fails.any() else from_m

    def _apart(self) -> list[FarImage]:
        """Return the newest look, and the earlier ones that `CameraSight` can count as further ones."""
        apart = [self.looks[0]]
        for look in self.looks[1:]:
            if apart[-1].found.time_s - look.found.time_s >= LOOK_SPACING_S and len(apart) < MAX_LOOKS:
                apart.append(look)
        return apart

    def _shown(self, look: FarImage, line: Floats) -> LaneCoverage:
        seen = points_into_vehicle(line, look.pose)
        return self.sight.look(look.found.time_s, look.found.look, seen, look.blockers)


def blockers_of(
    tracks: Sequence[Track], found: FarDetections, places: FarPlaces, rig: CameraRig, pose: PoseEstimate
) -> Floats:
    """(n, 7): what hides lanes in an image, in the vehicle frame: tracks, and the camera's own detections."""
    known = boxes_of(tracks, pose)
    near_m = np.maximum(places.range_m - SURE_SDS * places.range_sigma_m, DEPTH_M)
    lens = np.array([rig.mount.x_m, rig.mount.y_m])
    xy = lens + (places.xy - lens) * (near_m / places.range_m)[:, None]
    wide = found.width / rig.focal_px * near_m
    rest = (np.full(len(found), HIGH_M / 2.0), np.full(len(found), DEPTH_M), wide, np.full(len(found), HIGH_M))
    own = np.column_stack([xy, *rest, np.arctan2(places.xy[:, 1], places.xy[:, 0])])
    every = np.concatenate([known, own])
    # A body behind the lens, or wholly outside the angle of view, hides nothing.
    reach = np.hypot(every[:, 3], every[:, 4]) / 2.0
    ahead = every[:, 0] - rig.mount.x_m + reach
    edge = ahead * rig.width_px / (2.0 * rig.focal_px)
    return np.asarray(every[(ahead > 0.0) & (np.abs(every[:, 1] - rig.mount.y_m) - reach < edge + reach)])


def _first(line: Floats, metres: float) -> Floats:
    """Return the first part of a line, with the point that ends it."""
    at = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    return line[: int(np.searchsorted(at, metres)) + 1]


def _rest(line: Floats, from_m: float) -> Floats:
    """Return the part of a line beyond its first `from_m` meters."""
    at = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    beyond = at > from_m
    first = [np.interp(from_m, at, line[:, k]) for k in (0, 1)]
    return np.concatenate([[first], line[beyond]]) if beyond.any() else np.zeros((0, 2))
