"""The range of a vehicle in the image, from where it touches the road and from its size."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from stucksolver_perception.camera.far_detector import FarDetections
from stucksolver_perception.camera.horizon_strip import horizon_row
from stucksolver_perception.measurements import Floats
from stucksolver_perception.rig import CameraRig

NEAREST_M, FARTHEST_M = 5.0, 400.0
"""Ranges outside are not believed."""
LEAST_SIDE_PX = 1.0
COLUMN_SIGMA_PX = 1.5
"""Error of a box's middle column: a larger one would count as a miss in the evaluation of the card."""


@dataclass(frozen=True)
class RangeModel:
    """How ranges follow from boxes; fitted to detections in held-out images, and stored in the network's card.

    The row in which a box ends is `row_bias_px` lower than on a flat road, with standard deviation `row_sigma_px`: the
    network's error and the road's slope together. The logarithm of the range is linear in those of width and height;
    the spread of vehicle sizes is in `size_sigma`.
    """

    row_bias_px: float
    row_sigma_px: float
    row_noise_px: float
    """Error of the detector alone: the distance of its lower edges from the true ones (px)."""
    size: tuple[tuple[float, float, float], ...]
    """For each label: constant, factors of log width and of log height."""
    size_sigma: tuple[float, ...]
    """For each label, of the range's logarithm."""
    half_length_m: tuple[float, ...]
    """For each label: distance from the nearest edge on the road to the center (m)."""
    inflation: float
    """Factor on the fused standard deviation: the two sources are not quite independent."""

    @staticmethod
    def from_card(card: Mapping[str, Any]) -> RangeModel:
        """Read the model from a network's card."""
        told = card["range"]
        return RangeModel(
            float(told["row_bias_px"]),
            float(told["row_sigma_px"]),
            float(told["row_noise_px"]),
            tuple((float(a), float(b), float(c)) for a, b, c in told["size"]),
            tuple(float(item) for item in told["size_sigma"]),
            tuple(float(item) for item in told["half_length_m"]),
            float(told["inflation"]),
        )


@dataclass(frozen=True, eq=False)
class FarPlaces:
    """Positions of detections in the vehicle frame; equal lengths n."""

    range_m: Floats
    """(n,): distance from the lens along the ground to the object's center (m)."""
    range_sigma_m: Floats
    xy: Floats
    """(n, 2)."""
    covariance: Floats
    """(n, 2, 2)."""


def far_places(found: FarDetections, rig: CameraRig, model: RangeModel, pitch_rad: float = 0.0) -> FarPlaces:
    """Return where detections are on a flat road.

    Args:
        found: From `FarDetector.detect`.
        rig: The same camera.
        model: See `RangeModel.from_card`.
        pitch_rad: As given to `detect` (rad).
    """
    range_m, sigma_m = ranges_of(found, rig, model, pitch_rad)
    return places_at(found, rig, range_m, sigma_m)


def places_at(found: FarDetections, rig: CameraRig, range_m: Floats, sigma_m: Floats) -> FarPlaces:
    """Return the positions of detections at known ranges: along the line of sight by these, across it by the column."""
    bearing = np.arctan2(rig.width_px / 2.0 - found.column, rig.focal_px) + np.radians(rig.mount.yaw_deg)
    along = np.stack([np.cos(bearing), np.sin(bearing)], 1)
    across = np.stack([-np.sin(bearing), np.cos(bearing)], 1)
    side_m = range_m * COLUMN_SIGMA_PX / rig.focal_px
    covariance = (sigma_m**2)[:, None, None] * along[:, :, None] * along[:, None, :]
    covariance = covariance + (side_m**2)[:, None, None] * across[:, :, None] * across[:, None, :]
    xy = np.array([rig.mount.x_m, rig.mount.y_m]) + range_m[:, None] * along
    return FarPlaces(range_m, sigma_m, xy, covariance)


def ranges_of(found: FarDetections, rig: CameraRig, model: RangeModel, pitch_rad: float = 0.0) -> tuple[Floats, Floats]:
    """Return the range and its standard deviation (m), from row and size together.

    Both are fused as Gaussians of the inverse range, in which a pixel's error of the row is constant.
    """
    by_row, row_sigma = by_row_of(found, rig, model, pitch_rad)
    by_size, size_sigma = by_size_of(found, model)
    weight_row, weight_size = row_sigma**-2.0, size_sigma**-2.0
    inverse = (by_row * weight_row + by_size * weight_size) / (weight_row + weight_size)
    inverse = np.clip(inverse, 1.0 / FARTHEST_M, 1.0 / NEAREST_M)
    # If row and size contradict each other more than their errors allow, the result is no surer than that difference.
    apart = np.abs(by_row - by_size) / np.sqrt(row_sigma**2 + size_sigma**2)
    sigma = model.inflation * np.maximum(apart / 2.0, 1.0) / np.sqrt(weight_row + weight_size)
    return 1.0 / inverse, sigma / inverse**2


def by_row_of(found: FarDetections, rig: CameraRig, model: RangeModel, pitch_rad: float = 0.0) -> tuple[Floats, Floats]:
    """Return the inverse range to the center (1/m) from the lower edge on a flat road, and its standard deviation."""
    scale = rig.focal_px * rig.mount.z_m
    below = np.maximum(found.row - model.row_bias_px - horizon_row(rig, pitch_rad), scale / FARTHEST_M)
    range_m = scale / below + np.array(model.half_length_m)[found.label]
    return 1.0 / range_m, np.full(len(found), model.row_sigma_px / scale)


def by_size_of(found: FarDetections, model: RangeModel) -> tuple[Floats, Floats]:
    """Return the inverse range (1/m) from width and height, and its standard deviation."""
    size = np.array(model.size)[found.label]
    logs = logs_of(found)
    inverse = np.exp(-np.sum(size * logs, axis=1))
    return inverse, inverse * np.array(model.size_sigma)[found.label]


def logs_of(found: FarDetections) -> Floats:
    """(n, 3): 1, and the logarithms of width and height."""
    sides = np.maximum(np.stack([found.width, found.height], 1), LEAST_SIDE_PX)
    return np.column_stack([np.ones(len(found)), np.log(sides)])
