"""Positions and properties of the sensors: one small file, `rig.toml`, read once at start."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
from pydantic import Field, ValidationError

from stucksolver.scene.base_model import FrozenModel, first_problem
from stucksolver_perception.measurements import Floats

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

SHIPPED = Path(__file__).with_name("rig.toml")
VERSION = 1
"""Version of rig files; increased with every change of the meaning of their fields."""


class RigError(ValueError):
    """The calibration cannot be used. The message names the file, the field and the remedy."""


class SensorMount(FrozenModel):
    """Position of a sensor: meters and degrees in the vehicle frame; yaw to the left and pitch down are positive."""

    x_m: float
    y_m: float
    z_m: float
    yaw_deg: float = 0.0
    pitch_deg: float = 0.0
    roll_deg: float = 0.0

    def to_vehicle(self) -> Floats:
        """(4, 4) matrix from the sensor's frame (x ahead, y left, z up) to the vehicle's."""
        yaw, pitch, roll = (math.radians(item) for item in (self.yaw_deg, self.pitch_deg, self.roll_deg))
        cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
        cr, sr = math.cos(roll), math.sin(roll)
        matrix = np.eye(4)
        matrix[:3, :3] = (
            np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
            @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
            @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
        )
        matrix[:3, 3] = self.x_m, self.y_m, self.z_m
        return matrix


class CameraRig(FrozenModel):
    """A camera: a pinhole without distortion, its principal point in the center."""

    mount: SensorMount
    width_px: int = Field(gt=0)
    height_px: int = Field(gt=0)
    fov_deg: float = Field(gt=0, lt=180, description="horizontal")

    @property
    def focal_px(self) -> float:
        """Focal length of both axes (px)."""
        return self.width_px / (2.0 * math.tan(math.radians(self.fov_deg) / 2.0))

    def project(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """Project vehicle-frame points (n, 3) to (column, row, distance ahead of the lens, not above 0 behind it)."""
        inverse = np.linalg.inv(self.mount.to_vehicle())
        seen = points @ inverse[:3, :3].T + inverse[:3, 3]
        ahead = seen[:, 0]
        safe = np.where(np.abs(ahead) < 1e-6, 1e-6, ahead)
        column = self.width_px / 2.0 - self.focal_px * seen[:, 1] / safe
        row = self.height_px / 2.0 - self.focal_px * seen[:, 2] / safe
        return column, row, ahead


class LidarRig(FrozenModel):
    """The LiDAR on the roof."""

    mount: SensorMount
    channels: int = Field(gt=0)
    range_m: float = Field(gt=0)
    turns_per_s: float = Field(gt=0)
    points_per_s: int = Field(gt=0)
    upper_deg: float
    lower_deg: float
    attenuation_per_m: float = 0.004
    dropoff_general: float = 0.45
    dropoff_intensity_limit: float = 0.8
    dropoff_zero_intensity: float = 0.4
    noise_m: float = 0.0


class Rig(FrozenModel):
    """All sensors of a vehicle."""

    version: int
    camera: CameraRig
    """The front camera."""
    rear_camera: CameraRig | None = None
    """What drives up from behind is recognized with it; None without one."""
    lidar: LidarRig
    gnss_noise_m: float
    """Standard deviation of each coordinate of a fix (m)."""
    imu_acceleration_noise_mps2: float
    imu_rotation_noise_rps: float
    wheel_speed_noise_mps: float


def load_rig(file: Path = SHIPPED) -> Rig:
    """Read a rig from a TOML file.

    Raises:
        RigError: The file cannot be read or has an error.
    """
    try:
        with file.open("rb") as stream:
            told = tomllib.load(stream)
        # Checked first: fields of another version may be unknown.
        if told.get("version") != VERSION:
            raise RigError(
                f"{file}: version {told.get('version', 'unnamed')} of rig files; this release reads {VERSION}: "
                f"rewrite the file, starting from {SHIPPED.name} of this release"
            )
        return Rig.model_validate(told)
    except OSError as error:
        raise RigError(f"{file}: the calibration cannot be read ({error.strerror}); give a rig file") from error
    except tomllib.TOMLDecodeError as error:
        raise RigError(f"{file}: invalid TOML: {error}") from error
    except ValidationError as error:
        raise RigError(f"{file}: {first_problem(error)}") from error
