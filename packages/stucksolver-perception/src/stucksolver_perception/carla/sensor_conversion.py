"""Converts the measurements of CARLA's sensors to the vehicle frame and the local frame.

CARLA measures in a left-handed frame (x ahead, y right, z up). A vector changes the sign of its y. A turn rate is a
pseudovector (v = w x r), so its x and z change their signs instead.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from stucksolver_perception.carla.georeference import GeoReference
from stucksolver_perception.measurements import Floats, GnssFix, ImuSample, Pixels, Singles

if TYPE_CHECKING:
    import carla

STOPPED_MPS = 0.02
"""Speed below which no tooth of a wheel's encoder passes between two ticks (m/s). Ours."""


def lidar_points(measured: carla.LidarMeasurement, to_vehicle: Floats) -> Singles:
    """Return (n, 4): x, y, z (m) in the vehicle frame, and intensity.

    `to_vehicle` is the (4, 4) matrix of the LiDAR's mount; see `SensorMount.to_vehicle`.
    """
    points: Singles = np.frombuffer(measured.raw_data, np.float32).reshape(-1, 4).copy()
    points[:, 1] *= -1.0
    turn, shift = to_vehicle[:3, :3].astype(np.float32), to_vehicle[:3, 3].astype(np.float32)
    points[:, :3] = points[:, :3] @ turn.T + shift
    return points


def camera_pixels(measured: carla.Image) -> Pixels:
    """Return (height, width, 4): the camera's BGRA image, not as a copy."""
    return np.frombuffer(measured.raw_data, np.uint8).reshape(measured.height, measured.width, 4)


def camera_rgb(measured: carla.Image) -> Pixels:
    """Return (height, width, 3): the camera's image as RGB."""
    return np.ascontiguousarray(camera_pixels(measured)[:, :, 2::-1])


def imu_sample(measured: carla.IMUMeasurement, time_s: float) -> ImuSample:
    """Return an IMU sample. CARLA's compass is 0 to the north (the local frame's y), and grows to the east (rad)."""
    a, w = measured.accelerometer, measured.gyroscope
    compass_rad = math.remainder(math.pi / 2.0 - measured.compass, math.tau)
    return ImuSample(time_s, (a.x, -a.y, a.z), (-w.x, w.y, -w.z), compass_rad)


def gnss_fix(measured: carla.GnssMeasurement, geo: GeoReference, time_s: float) -> GnssFix:
    """Return a fix on the map of `geo`."""
    x_m, y_m = geo.local(measured.latitude, measured.longitude)
    return GnssFix(time_s, x_m, y_m, measured.altitude)


def wheel_speed_mps(speed_mps: float, noise_mps: float, random: np.random.Generator) -> float:
    """Return the wheels' measurement of a true speed, with Gaussian noise. CARLA has no such sensor.

    A random number is drawn in any case, so that later ones do not depend on earlier stops.
    """
    noise = float(random.normal(0.0, noise_mps))
    # The encoder of a stopped wheel counts no teeth, so it has no error.
    return speed_mps + noise if abs(speed_mps) > STOPPED_MPS else 0.0
