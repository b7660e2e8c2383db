"""The sensors' measurements, each with its time; arrays are not copied and must not be written to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Pixels = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class LidarSweep:
    """The points of one LiDAR measurement (in CARLA: one tick, a part of a turn)."""

    time_s: float
    points: Singles
    """(n, 4): x, y, z (m) in the vehicle frame at `time_s`, and intensity (0 to 1)."""


@dataclass(frozen=True, eq=False)
class CameraFrame:
    """One image of the front camera."""

    time_s: float
    rgb: Pixels
    """(height, width, 3)."""
    covered: NDArray[np.bool_] | None = None
    """(rows, columns): the image in equal cells, True where dirt is on the lens; None if none is known."""


@dataclass(frozen=True)
class GnssFix:
    """A satellite position in the local frame, of the receiver at the vehicle's reference point."""

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
    """About x, y and z; the last is the yaw rate, positive to the left."""
    compass_rad: float | None = None
    """Yaw in the local frame from the magnetic field, counter-clockwise from x; None without a compass."""


@dataclass(frozen=True)
class WheelSpeed:
    """Speed along the heading by the wheels; negative in reverse."""

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
    """Along the heading."""
    yaw_rate_rps: float
    covariance: Floats
    """(4, 4) of x, y (m), yaw (rad), speed (m/s)."""


@dataclass(frozen=True, eq=False)
class Detections:
    """Boxes detected in the sensors' data of one moment, in the vehicle frame at `time_s`; equal lengths n."""

    time_s: float
    label: NDArray[np.int64]
    """(n,): index into `stucksolver_perception.lidar_labels.LABELS`."""
    score: Floats
    """(n,): 0 to 1, calibrated as the share of such boxes that are right."""
    center: Floats
    """(n, 3): the middle of the box (m)."""
    size: Floats
    """(n, 3): length, width, height (m)."""
    yaw: Floats
    """(n,)."""
    velocity: Floats
    """(n, 2): over ground (not relative to the ego), along the vehicle frame's x and y (m/s)."""
    height_known: NDArray[np.bool_] | None = None
    """(n,): True where the height was measured (`lidar/low.py`) and not guessed; None if it was nowhere."""

    def __len__(self) -> int:
        return len(self.label)

    def part(self, which: NDArray[Any]) -> Detections:
        """Return some of them, by a mask or by indices."""
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
