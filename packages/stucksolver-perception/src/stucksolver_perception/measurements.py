"""Defines the sensors' measurements, each with its time. Arrays are not copied and must not be written to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
"""Array of double-precision numbers."""
Singles = NDArray[np.float32]
"""Array of single-precision numbers."""
Pixels = NDArray[np.uint8]
"""Array of an image's values, 0 to 255."""


@dataclass(frozen=True, eq=False)
class LidarSweep:
    """The points of one LiDAR measurement. In CARLA it belongs to one tick, and is a part of a turn."""

    time_s: float
    points: Singles
    """(n, 4): x, y, z (m) in the vehicle frame at `time_s`, and intensity (0 to 1)."""


@dataclass(frozen=True, eq=False)
class CameraFrame:
    """One image of the front camera."""

    time_s: float
    rgb: Pixels
    """(height, width, 3): the image as RGB."""
    covered: NDArray[np.bool_] | None = None
    """(rows, columns): the image in equal cells, True for dirt on the lens; None without detected dirt."""


@dataclass(frozen=True)
class GnssFix:
    """A satellite fix of the receiver at the vehicle's reference point, in the local frame."""

    time_s: float
    x_m: float
    y_m: float
    z_m: float


@dataclass(frozen=True)
class ImuSample:
    """Accelerations and turn rates in the vehicle frame's axes; gravity is part of `acceleration_mps2[2]`."""

    time_s: float
    acceleration_mps2: tuple[float, float, float]
    rotation_rps: tuple[float, float, float]
    """Turn rates about x, y and z (rad/s). The last one is the yaw rate, positive to the left."""
    compass_rad: float | None = None
    """Yaw in the local frame from the magnetic field, counter-clockwise from x (rad); None without a compass."""


@dataclass(frozen=True)
class WheelSpeed:
    """Speed along the heading from the wheels; negative in reverse."""

    time_s: float
    speed_mps: float


@dataclass(frozen=True, eq=False)
class PoseEstimate:
    """The estimated pose of the vehicle's reference point in the local frame."""

    time_s: float
    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float
    speed_mps: float
    """Speed along the heading (m/s)."""
    yaw_rate_rps: float
    covariance: Floats
    """(4, 4): covariance of x, y (m), yaw (rad) and speed (m/s)."""


@dataclass(frozen=True, eq=False)
class Detections:
    """Boxes detected in the sensors' data at `time_s`, in the vehicle frame of that time; equal lengths n."""

    time_s: float
    label: NDArray[np.int64]
    """(n,): index into `stucksolver_perception.lidar_labels.LABELS`."""
    score: Floats
    """(n,): 0 to 1, calibrated as the share of such boxes that are correct."""
    center: Floats
    """(n, 3): center of the box (m)."""
    size: Floats
    """(n, 3): length, width, height (m)."""
    yaw: Floats
    """(n,): yaw (rad)."""
    velocity: Floats
    """(n, 2): velocity over ground, not relative to the ego, along the vehicle frame's x and y (m/s)."""
    height_known: NDArray[np.bool_] | None = None
    """(n,): True if the height was measured (`lidar/refinement/debris_height.py`) and not estimated by the network;
    None if no height was."""

    def __len__(self) -> int:
        return len(self.label)

    def part(self, which: NDArray[Any]) -> Detections:
        """Return some of the boxes, selected with a mask or with indices."""
        return Detections(
            self.time_s,
            self.label[which],
            self.score[which],
            self.center[which],
            self.size[which],
            self.yaw[which],
            self.velocity[which],
            None if self.height_known is None else self.height_known[which],
        )
