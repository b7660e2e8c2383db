"""Places far detections on lanes of the map. A lane's course and heights give a better range than a flat road."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver_perception.camera.far_detector import FarDetections
from stucksolver_perception.camera.far_range import COLUMN_SIGMA_PX, RangeModel, by_size_of
from stucksolver_perception.measurements import Floats
from stucksolver_perception.rig import CameraRig

STEP_M = 1.0
"""Distance between the positions on the lane that are compared (m). Ours."""
LANE_SIGMA_M = 0.8
"""Standard deviation of the distance of vehicles from the lane's center (m). Ours."""
NEAREST_M = 5.0
"""Minimum distance of a position from the lens (m). Ours."""


@dataclass(frozen=True, eq=False)
class LanePlaces:
    """The positions of n detections under the assumption that they are on the lane."""

    along_m: Floats
    """(n,): distance along the lane's line from its start (m)."""
    sigma_m: Floats
    """(n,): standard deviation of that distance (m)."""
    xy: Floats
    """(n, 2): position on the lane's center in the vehicle frame (m)."""
    misfit: Floats
    """(n,): the smallest sum of squared errors of column, row and size, each in standard deviations. Above 9 the
    detection is hardly on this lane. It is infinite if no part of the lane is ahead.
    """


def place_on_lane(detections: FarDetections, rig: CameraRig, model: RangeModel, line: Floats) -> LanePlaces:
    """Return the positions of detections along a lane.

    Args:
        detections: From `FarDetector.detect`.
        rig: The same camera.
        model: See `RangeModel.from_card`.
        line: The lane's center (k, 2) or (k, 3) in the vehicle frame. With heights, the row in which a vehicle touches
            the road has only the detector's own error. Without heights, it has the error of a flat road.
    """
    course, along = resampled(line, STEP_M)
    column, row, ahead = rig.project(course)
    is_ahead = ahead > NEAREST_M
    unknown = np.full(len(detections), np.nan)
    if not is_ahead.any():
        return LanePlaces(unknown, unknown, np.stack([unknown, unknown], 1), np.full(len(detections), np.inf))
    course, along, column, row, ahead = (item[is_ahead] for item in (course, along, column, row, ahead))
    half_length_m = np.array(model.half_length_m)[detections.label]
    # The lower edge of a vehicle in the image is its near end, half a length before its center.
    edge = np.interp(along[None] - half_length_m[:, None], along, row)
    row_sigma = model.row_noise_px if line.shape[1] > 2 else model.row_sigma_px
    bias = 0.0 if line.shape[1] > 2 else model.row_bias_px
    column_sigma = np.hypot(COLUMN_SIGMA_PX, rig.focal_px * LANE_SIGMA_M / ahead)
    inverse, inverse_sigma = by_size_of(detections, model)
    range_m = np.hypot(course[:, 0] - rig.mount.x_m, course[:, 1] - rig.mount.y_m)
    cost = ((column[None] - detections.column[:, None]) / column_sigma[None]) ** 2
    cost += ((edge + bias - detections.row[:, None]) / row_sigma) ** 2
    cost += ((1.0 / range_m[None] - inverse[:, None]) / inverse_sigma[:, None]) ** 2
    min_cost = cost.min(axis=1)
    weight = np.exp(-(cost - min_cost[:, None]) / 2.0)
    weight /= weight.sum(axis=1, keepdims=True)
    mean = weight @ along
    spread = np.sqrt(np.maximum(weight @ along**2 - mean**2, STEP_M**2 / 12.0))
    xy = np.stack([np.interp(mean, along, course[:, k]) for k in (0, 1)], 1)
    return LanePlaces(mean, spread * model.inflation, xy, min_cost)


def resampled(line: Floats, step_m: float) -> tuple[Floats, Floats]:
    """Return points (m, 3) of a line (k, 2) or (k, 3) every `step_m`, and their distances along it.

    Heights default to 0.
    """
    points = line if line.shape[1] == 3 else np.column_stack([line, np.zeros(len(line))])
    lengths = np.hypot(np.diff(points[:, 0]), np.diff(points[:, 1]))
    arc_lengths = np.concatenate([[0.0], np.cumsum(lengths)])
    along = np.arange(0.0, arc_lengths[-1] + 1e-9, step_m)
    return np.stack([np.interp(along, arc_lengths, points[:, k]) for k in range(3)], 1), along
