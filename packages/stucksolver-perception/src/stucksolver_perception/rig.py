"""Reads mounts and properties of the sensors from one small file, `rig.toml`, once at start."""

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
"""The rig file that ships with the package."""
VERSION = 1
"""Version of rig files; increased with every change of the meaning of their fields."""


class RigError(ValueError):
    """The rig file cannot be used. The message names the file, the field and the remedy."""


class SensorMount(FrozenModel):
    """Pose of a sensor: meters and degrees in the vehicle frame. Yaw to the left and pitch down are positive."""

    x_m: float
    y_m: float
    z_m: float
    yaw_deg: float = 0.0
    pitch_deg: float = 0.0
    roll_deg: float = 0.0

    def to_vehicle(self) -> Floats:
        """Return (4, 4): the matrix from the sensor's frame (x ahead, y left, z up) to the vehicle frame."""
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
    """A pinhole camera without distortion, with the principal point in the center."""

    mount: SensorMount
    width_px: int = Field(gt=0)
    height_px: int = Field(gt=0)
    fov_deg: float = Field(gt=0, lt=180, description="horizontal")

    @property
    def focal_px(self) -> float:
        """Focal length of both axes (px)."""
        return self.width_px / (2.0 * math.tan(math.radians(self.fov_deg) / 2.0))

    def project(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """Return columns and rows (px) of points (n, 3; vehicle frame), and their distances ahead of the lens (m).

        Behind the lens the distance is not above 0, and column and row are meaningless.
        """
        inverse = np.linalg.inv(self.mount.to_vehicle())
        in_camera = points @ inverse[:3, :3].T + inverse[:3, 3]
        ahead = in_camera[:, 0]
        safe = np.where(np.abs(ahead) < 1e-6, 1e-6, ahead)
        column = self.width_px / 2.0 - self.focal_px * in_camera[:, 1] / safe
        row = self.height_px / 2.0 - self.focal_px * in_camera[:, 2] / safe
        return column, row, ahead


class LidarRig(FrozenModel):
    """The LiDAR on the roof. The last five fields are attributes of CARLA's LiDAR, with CARLA's defaults."""

    mount: SensorMount
    channels: int = Field(gt=0)
    range_m: float = Field(gt=0)
    turns_per_s: float = Field(gt=0)
    points_per_s: int = Field(gt=0)
    upper_deg: float
    """Elevation of the highest channel (degrees)."""
    lower_deg: float
    """Elevation of the lowest channel (degrees)."""
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
    """The rear camera, which recognizes vehicles that approach from behind; None without one."""
    lidar: LidarRig
    gnss_noise_m: float
    """Standard deviation of each coordinate of a fix (m)."""
    imu_acceleration_noise_mps2: float
    """Standard deviation of each acceleration (m/s²)."""
    imu_rotation_noise_rps: float
    """Standard deviation of each turn rate (rad/s)."""
    wheel_speed_noise_mps: float
    """Standard deviation of the wheels' speed (m/s)."""


def load_rig(file: Path = SHIPPED) -> Rig:
    """Read a rig from a TOML file.

    Raises:
        RigError: The file cannot be read or has an error.
    """
    try:
        with file.open("rb") as stream:
            content = tomllib.load(stream)
        # The version is checked first, because a file of another version may have unknown fields.
        if content.get("version") != VERSION:
            raise RigError(
                f"{file}: version {content.get('version', 'unnamed')} of rig files; this release reads {VERSION}: "
                f"rewrite the file, starting from {SHIPPED.name} of this release"
            )
        return Rig.model_validate(content)
    except OSError as error:
        raise RigError(f"{file}: the rig file cannot be read ({error.strerror}); give a rig file") from error
    except tomllib.TOMLDecodeError as error:
        raise RigError(f"{file}: invalid TOML: {error}") from error
    except ValidationError as error:
        raise RigError(f"{file}: {first_problem(error)}") from error
