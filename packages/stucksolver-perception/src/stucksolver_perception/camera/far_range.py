"""Computes the range of a vehicle in the image from its contact with the road and from its size."""

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
"""Bounds of a plausible range (m). Ours."""
MIN_SIDE_PX = 1.0
"""Lower bound of width and height, for their logarithms (px). Ours."""
COLUMN_SIGMA_PX = 1.5
"""Standard deviation of a box's middle column (px). Larger errors count as misses in the evaluation of the card."""


@dataclass(frozen=True)
class RangeModel:
    """The relation between boxes and ranges, fitted to detections in held-out images and stored in the network's card.

    A box's lower edge is `row_bias_px` lower than on a flat road, with standard deviation `row_sigma_px`: the network's
    error and the road's slope together. The logarithm of the range is linear in the logarithms of width and height.
    `size_sigma` contains the spread of vehicle sizes.
    """

    row_bias_px: float
    row_sigma_px: float
    row_noise_px: float
    """Error of the detector alone: distance of its lower edges from the true ones (px)."""
    size: tuple[tuple[float, float, float], ...]
    """For each label: constant, factors of log width and of log height."""
    size_sigma: tuple[float, ...]
    """For each label: standard deviation of the range's logarithm."""
    half_length_m: tuple[float, ...]
    """For each label: distance from the nearest edge on the road to the center (m)."""
    inflation: float
    """Factor of the fused standard deviation, because the two sources are not fully independent."""

    @staticmethod
    def from_card(card: Mapping[str, Any]) -> RangeModel:
        """Read the model from a network's card."""
        fields = card["range"]
        return RangeModel(
            float(fields["row_bias_px"]),
            float(fields["row_sigma_px"]),
            float(fields["row_noise_px"]),
            tuple((float(a), float(b), float(c)) for a, b, c in fields["size"]),
            tuple(float(item) for item in fields["size_sigma"]),
            tuple(float(item) for item in fields["half_length_m"]),
            float(fields["inflation"]),
        )


@dataclass(frozen=True, eq=False)
class FarPlaces:
    """Positions of n detections in the vehicle frame."""

    range_m: Floats
    """(n,): distance from the lens along the ground to the object's center (m)."""
    range_sigma_m: Floats
    """(n,): standard deviation of the range (m)."""
    xy: Floats
    """(n, 2): position (m)."""
    covariance: Floats
    """(n, 2, 2): covariance of the position (m²)."""


def far_places(detections: FarDetections, rig: CameraRig, model: RangeModel, pitch_rad: float = 0.0) -> FarPlaces:
    """Return the positions of detections on a flat road.

    Args:
        detections: From `FarDetector.detect`.
        rig: The same camera.
        model: See `RangeModel.from_card`.
        pitch_rad: As in `FarDetector.detect` (rad).
    """
    range_m, sigma_m = ranges_of(detections, rig, model, pitch_rad)
    return places_at(detections, rig, range_m, sigma_m)


def places_at(detections: FarDetections, rig: CameraRig, range_m: Floats, sigma_m: Floats) -> FarPlaces:
    """Return the positions of detections at known ranges: the ranges along the line of sight, the columns across it."""
    bearing = np.arctan2(rig.width_px / 2.0 - detections.column, rig.focal_px) + np.radians(rig.mount.yaw_deg)
    along = np.stack([np.cos(bearing), np.sin(bearing)], 1)
    across = np.stack([-np.sin(bearing), np.cos(bearing)], 1)
    side_m = range_m * COLUMN_SIGMA_PX / rig.focal_px
    covariance = (sigma_m**2)[:, None, None] * along[:, :, None] * along[:, None, :]
    covariance = covariance + (side_m**2)[:, None, None] * across[:, :, None] * across[:, None, :]
    xy = np.array([rig.mount.x_m, rig.mount.y_m]) + range_m[:, None] * along
    return FarPlaces(range_m, sigma_m, xy, covariance)


def ranges_of(
    detections: FarDetections, rig: CameraRig, model: RangeModel, pitch_rad: float = 0.0
) -> tuple[Floats, Floats]:
    """Return the range and its standard deviation (m), from row and size together.

    Both are fused as Gaussians of the inverse range, in which a row error of one pixel is constant.
    """
    by_row, row_sigma = by_row_of(detections, rig, model, pitch_rad)
    by_size, size_sigma = by_size_of(detections, model)
    weight_row, weight_size = row_sigma**-2.0, size_sigma**-2.0
    inverse = (by_row * weight_row + by_size * weight_size) / (weight_row + weight_size)
    inverse = np.clip(inverse, 1.0 / FARTHEST_M, 1.0 / NEAREST_M)
    # If row and size differ by more than their errors, the standard deviation grows with the difference.
    difference = np.abs(by_row - by_size) / np.sqrt(row_sigma**2 + size_sigma**2)
    sigma = model.inflation * np.maximum(difference / 2.0, 1.0) / np.sqrt(weight_row + weight_size)
    return 1.0 / inverse, sigma / inverse**2


def by_row_of(
    detections: FarDetections, rig: CameraRig, model: RangeModel, pitch_rad: float = 0.0
) -> tuple[Floats, Floats]:
    """Return the inverse range to the center (1/m) from the lower edge on a flat road, and its standard deviation."""
    scale = rig.focal_px * rig.mount.z_m
    below_px = np.maximum(detections.row - model.row_bias_px - horizon_row(rig, pitch_rad), scale / FARTHEST_M)
    range_m = scale / below_px + np.array(model.half_length_m)[detections.label]
    return 1.0 / range_m, np.full(len(detections), model.row_sigma_px / scale)


def by_size_of(detections: FarDetections, model: RangeModel) -> tuple[Floats, Floats]:
    """Return the inverse range (1/m) from width and height, and its standard deviation."""
    size = np.array(model.size)[detections.label]
    logs = logs_of(detections)
    inverse = np.exp(-np.sum(size * logs, axis=1))
    return inverse, inverse * np.array(model.size_sigma)[detections.label]


def logs_of(detections: FarDetections) -> Floats:
    """Return (n, 3): 1, and the logarithms of width and height."""
    sides = np.maximum(np.stack([detections.width, detections.height], 1), MIN_SIDE_PX)
    return np.column_stack([np.ones(len(detections)), np.log(sides)])
