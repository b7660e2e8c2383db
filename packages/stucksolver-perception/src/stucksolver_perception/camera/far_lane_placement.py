"""Places far detections on lanes of the map: a lane's course and heights give a better range than a flat road."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver_perception.camera.far_detector import FarDetections
from stucksolver_perception.camera.far_range import COLUMN_SIGMA_PX, RangeModel, by_size_of
from stucksolver_perception.measurements import Floats
from stucksolver_perception.rig import CameraRig

STEP_M = 1.0
"""Distance between the places on the lane that are compared."""
LANE_SIGMA_M = 0.8
"""Distance of vehicles from the lane's center."""
NEAREST_M = 5.0


@dataclass(frozen=True, eq=False)
class LanePlaces:
    """The position of each of n detections if it is on the lane; `misfit` says whether it can be."""

    along_m: Floats
    """(n,): distance along the lane's line from its start."""
    sigma_m: Floats
    xy: Floats
    """(n, 2): position on the lane's center, in the vehicle frame."""
    misfit: Floats
    """(n,): the smallest sum of squared errors of column, row and size, each in standard deviations. Above 9 the
    lane is hardly the right one. Infinite if no part of the lane is ahead.
    """


def on_lane(found: FarDetections, rig: CameraRig, model: RangeModel, line: Floats) -> LanePlaces:
    """Return where detections are along a lane.

    Args:
        found: From `FarDetector.detect`.
        rig: The same camera.
        model: See `RangeModel.from_card`.
        line: The lane's center (k, 2) or (k, 3) in the vehicle frame. With heights, the row in which a vehicle touches
            the road has only the detector's own error; without, the error is that of a flat road.
    """
    course, along = resampled(line, STEP_M)
    column, row, ahead = rig.project(course)
    front = ahead > NEAREST_M
    nothing = np.full(len(found), np.nan)
    if not front.any():
        return LanePlaces(nothing, nothing, np.stack([nothing, nothing], 1), np.full(len(found), np.inf))
    course, along, column, row, ahead = (item[front] for item in (course, along, column, row, ahead))
    near_m = np.array(model.half_length_m)[found.label]
    # A vehicle's lower edge is that of its near end, half a length before its center.
    edge = np.interp(along[None] - near_m[:, None], along, row)
    row_sigma = model.row_noise_px if line.shape[1] > 2 else model.row_sigma_px
    bias = 0.0 if line.shape[1] > 2 else model.row_bias_px
    column_sigma = np.hypot(COLUMN_SIGMA_PX, rig.focal_px * LANE_SIGMA_M / ahead)
    inverse, inverse_sigma = by_size_of(found, model)
    away = np.hypot(course[:, 0] - rig.mount.x_m, course[:, 1] - rig.mount.y_m)
    cost = ((column[None] - found.column[:, None]) / column_sigma[None]) ** 2
    cost += ((edge + bias - found.row[:, None]) / row_sigma) ** 2
    cost += ((1.0 / away[None] - inverse[:, None]) / inverse_sigma[:, None]) ** 2
    least = cost.min(axis=1)
    weight = np.exp(-(cost - least[:, None]) / 2.0)
    weight /= weight.sum(axis=1, keepdims=True)
    mean = weight @ along
    spread = np.sqrt(np.maximum(weight @ along**2 - mean**2, STEP_M**2 / 12.0))
    xy = np.stack([np.interp(mean, along, course[:, k]) for k in (0, 1)], 1)
    return LanePlaces(mean, spread * model.inflation, xy, least)


def resampled(line: Floats, step_m: float) -> tuple[Floats, Floats]:
    """Return (m, 3) points of a line (k, 2) or (k, 3) every `step_m`, and the distance along it of each; heights
    default to 0.
    """
    points = line if line.shape[1] == 3 else np.column_stack([line, np.zeros(len(line))])
    lengths = np.hypot(np.diff(points[:, 0]), np.diff(points[:, 1]))
    at = np.concatenate([[0.0], np.cumsum(lengths)])
    along = np.arange(0.0, at[-1] + 1e-9, step_m)
    return np.stack([np.interp(along, at, points[:, k]) for k in range(3)], 1), along
