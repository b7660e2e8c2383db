"""Computes the camera's sight distance along a lane from the last images and their detections.

Assumptions, besides those of `camera/camera_sight_distance.py`:

* The road is flat, because lanes come without heights. The detector's measured recall includes vehicles behind crests.
* A detected vehicle hides the area behind it, even if it is not tracked yet. Its range is assumed to be two standard
  deviations shorter than measured.
* A vehicle that was not in the image has moved until now, so the sight distance is reduced by that distance.
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
"""Maximum age of the newest image (s). An older one means that two images are missing."""
MEMORY_S = LOOK_SPACING_S * MAX_LOOKS
"""Maximum age of an image that can count (s)."""
NEAR_BOUND_SDS = 2.0
"""Number of standard deviations of the range by which a detection is assumed nearer. Ours."""
STEP_M = 5.0
"""Distance between the ranges at which the detector's recall is looked up (m); its bins are 25 m wide."""
MIN_DEPTH_M, MIN_HEIGHT_M = 2.0, 1.5
"""Length and height with which a detection hides the area behind it (m): those of a small car. Ours."""


@dataclass(frozen=True, eq=False)
class FarImage:
    """One image with its detections."""

    detections: FarDetections
    pose: PoseEstimate
    """Pose at the time of the image."""
    occluders: Floats
    """(n, 7): boxes of the tracks and detections at that time, in the vehicle frame at `pose`."""


@dataclass(frozen=True, eq=False)
class FarView:
    """The last images, the newest first."""

    images: tuple[FarImage, ...]
    sight: CameraSight
    model: SightModel
    """The same model as in `sight`."""

    def with_image(self, image: FarImage) -> FarView:
        """Return the view with a later image, and without those that are too old."""
        recent = (item for item in self.images if image.detections.time_s - item.detections.time_s <= MEMORY_S)
        return replace(self, images=(image, *recent))

    def clear_length_m(self, line: Floats, from_m: float, fastest_mps: float, now_s: float) -> float:
        """Return the length of a lane, from its start, that is proven free of vehicles (m).

        Another sensor proves it up to `from_m`, and the camera beyond.

        Args:
            line: The lane's center (k, 2) in the local frame, starting next to the ego.
            from_m: Sight distance of the other sensor (m). The camera continues from there, and only if that is beyond
                the range from which its recall was measured.
            fastest_mps: Highest speed of vehicles in the lane (m/s).
            now_s: The present time (s).
        """
        if not self.images or len(line) < 2:
            return from_m
        newest = self.images[0]
        age_s = now_s - newest.detections.time_s
        beyond = _part_beyond(line, from_m)
        if age_s > FRESH_S or len(beyond) < 2:
            return from_m
        start = points_into_vehicle(beyond[:1], newest.pose)[0]
        start_range_m = float(np.hypot(*start))
        max_m = self._reach_m(newest.detections.look, start_range_m) - start_range_m
        if start_range_m < NEAR_M or start[0] < 0.0 or max_m <= 0.0:
            return from_m
        # A lane is nowhere shorter than the line of sight, but a bend makes it longer. Objects that hide only the part
        # up to `from_m` do not count: the roof of a car ahead may hide the road up to there, and not beyond.
        beyond = _part_up_to(beyond, 2.0 * max_m)
        coverages = [self._coverage_in(image, beyond) for image in self._independent_images()]
        # A vehicle may have entered an earlier image's view since then; see the module's text.
        moved = [item.moved(fastest_mps * (newest.detections.time_s - item.time_s)) for item in coverages]
        visible_m = self.sight.visible_length_m(points_into_vehicle(beyond, newest.pose), moved[0], moved[1:])
        return from_m + max(visible_m - fastest_mps * max(age_s, 0.0), 0.0)

    def _reach_m(self, look: Floats, from_m: float) -> float:
        """Return the range up to which the detector can be reliable in such images (m); at least `from_m`."""
        ranges = np.arange(from_m, self.model.bins_m[-1] + STEP_M, STEP_M)
        missed = self.model.miss_at(ranges, look) * self.model.again ** (MAX_LOOKS - 1)
        fails = missed > 1.0 - REQUIRED_PROB
        return float(ranges[fails][0]) if fails.any() else from_m

    def _independent_images(self) -> list[FarImage]:
        """Return the newest image, and earlier ones with enough time between them to count as further looks."""
        images = [self.images[0]]
        for image in self.images[1:]:
            spacing_s = images[-1].detections.time_s - image.detections.time_s
            if spacing_s >= LOOK_SPACING_S and len(images) < MAX_LOOKS:
                images.append(image)
        return images

    def _coverage_in(self, image: FarImage, line: Floats) -> LaneCoverage:
        course = points_into_vehicle(line, image.pose)
        return self.sight.look(image.detections.time_s, image.detections.look, course, image.occluders)


def occluders_in(
    tracks: Sequence[Track], detections: FarDetections, places: FarPlaces, rig: CameraRig, pose: PoseEstimate
) -> Floats:
    """Return (n, 7): boxes of the tracks and detections that may hide lanes in an image, in the vehicle frame."""
    count = len(detections)
    near_m = np.maximum(places.range_m - NEAR_BOUND_SDS * places.range_sigma_m, MIN_DEPTH_M)
    lens = np.array([rig.mount.x_m, rig.mount.y_m])
    xy = lens + (places.xy - lens) * (near_m / places.range_m)[:, None]
    width = detections.width / rig.focal_px * near_m
    sizes = (np.full(count, MIN_HEIGHT_M / 2.0), np.full(count, MIN_DEPTH_M), width, np.full(count, MIN_HEIGHT_M))
    detected = np.column_stack([xy, *sizes, np.arctan2(places.xy[:, 1], places.xy[:, 0])])
    boxes = np.concatenate([boxes_of(tracks, pose), detected])
    # A box behind the lens, or entirely outside the angle of view, hides nothing.
    reach = np.hypot(boxes[:, 3], boxes[:, 4]) / 2.0
    ahead = boxes[:, 0] - rig.mount.x_m + reach
    edge = ahead * rig.width_px / (2.0 * rig.focal_px)
    return np.asarray(boxes[(ahead > 0.0) & (np.abs(boxes[:, 1] - rig.mount.y_m) - reach < edge + reach)])


def _part_up_to(line: Floats, length_m: float) -> Floats:
    """Return the first part of a line, up to the first point at this length or beyond."""
    arc_lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    return line[: int(np.searchsorted(arc_lengths, length_m)) + 1]


def _part_beyond(line: Floats, from_m: float) -> Floats:
    """Return the part of a line beyond its first `from_m` meters."""
    arc_lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    beyond = arc_lengths > from_m
    first = [np.interp(from_m, arc_lengths, line[:, k]) for k in (0, 1)]
    return np.concatenate([[first], line[beyond]]) if beyond.any() else np.zeros((0, 2))
