"""The rig's sensors on a vehicle in CARLA, for recording: all data of each tick, in the frames of perception."""

from __future__ import annotations

import contextlib
import io
import queue
import time
from typing import Any

import carla
import numpy as np
from numpy.typing import NDArray

from stucksolver_carla.perception_interface import SensorError
from stucksolver_perception.carla.georeference import GeoReference
from stucksolver_perception.carla.sensor_conversion import camera_pixels, camera_rgb, gnss_fix, imu_sample, lidar_points
from stucksolver_perception.carla.sensor_mounting import (
    SensorSetup,
    camera_setup,
    gnss_setup,
    imu_setup,
    lidar_setup,
    mount_sensor,
)
from stucksolver_perception.measurements import Floats, Singles
from stucksolver_perception.rig import Rig

DATA_LIMIT_S = 60.0
"""Wall time limit for a sensor's data of one tick (s). Ours.

The first images of a town take longest.
"""
JPEG_QUALITY = 95
"""Quality of the JPEG images (0 to 100). Ours.

It is high, and without chroma subsampling: a lamp has few pixels, and the vehicle uses raw images.
"""
INSTANCE_CAMERA = "sensor.camera.instance_segmentation"


class MountedSensor:
    """One sensor of the simulator, with a queue of its measurements.

    Raises:
        SensorError: The sensor cannot be mounted.
    """

    def __init__(self, hero: carla.Vehicle, setup: SensorSetup) -> None:
        self.type_id = setup.type_id
        self._data: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._actor = mount_sensor(hero, setup)
        self._actor.listen(self._data.put)

    def measurement(self, frame: int) -> Any:
        """Return the measurement of a frame and drop older ones.

        Raises:
            SensorError: The measurement does not arrive.
        """
        until_s = time.monotonic() + DATA_LIMIT_S
        while True:
            try:
                data = self._data.get(timeout=max(until_s - time.monotonic(), 0.0))
            except queue.Empty:
                raise SensorError(
                    f"{self.type_id} sent no data for frame {frame} within {DATA_LIMIT_S:.0f} s; run again"
                ) from None
            if data.frame == frame:
                return data
            if data.frame > frame:
                raise SensorError(f"{self.type_id} skipped frame {frame}; run again")

    def first_frame(self) -> int | None:
        """Drop the oldest measurement in the queue and return its frame; None if the queue is empty."""
        # An empty queue means that no image has arrived.
        with contextlib.suppress(queue.Empty):
            return int(self._data.get_nowait().frame)
        return None

    def close(self) -> None:
        """Destroy the sensor. Errors are ignored because the simulator may already be gone."""
        # The simulator may already be gone.
        with contextlib.suppress(RuntimeError):
            self._actor.stop()
            self._actor.destroy()


class RecordingSensors:
    """All sensors of a rig on one vehicle, and an instance camera at the camera's pose.

    Args:
        hero: The vehicle.
        rig: The rig.
        carla_map: The map, for the geographic reference.
        picture_period_s: Time between two images (s).
        seed: Seed of the noise of LiDAR, IMU and GNSS.

    Raises:
        SensorError: In all methods that take a frame: a measurement does not arrive.
    """

    def __init__(self, hero: carla.Vehicle, rig: Rig, carla_map: carla.Map, picture_period_s: float, seed: int) -> None:
        self._geo = GeoReference(carla_map.to_opendrive())
        self._to_vehicle = rig.lidar.mount.to_vehicle()
        self._lidar = MountedSensor(hero, lidar_setup(rig, seed))
        self._imu = MountedSensor(hero, imu_setup(rig, seed))
        self._gnss = MountedSensor(hero, gnss_setup(rig, seed))
        self._camera = MountedSensor(hero, camera_setup(rig.camera, picture_period_s))
        self._instances = MountedSensor(hero, camera_setup(rig.camera, picture_period_s, INSTANCE_CAMERA))

    def first_picture(self) -> int | None:
        """Return the frame of the first image, or None if it has not arrived; the next ones follow periodically."""
        return self._camera.first_frame()

    def points(self, frame: int) -> Singles:
        """Return a frame's sweep, shape (n, 4): x, y, z in the vehicle frame (m), and intensity."""
        return lidar_points(self._lidar.measurement(frame), self._to_vehicle)

    def imu(self, frame: int) -> Floats:
        """Return a frame's accelerations (m/s²), turn rates (rad/s) and compass (rad), shape (7,)."""
        sample = imu_sample(self._imu.measurement(frame), 0.0)
        return np.array([*sample.acceleration_mps2, *sample.rotation_rps, sample.compass_rad], np.float64)

    def gnss(self, frame: int) -> Floats:
        """Return a frame's GNSS fix in the local frame (m), shape (3,)."""
        fix = gnss_fix(self._gnss.measurement(frame), self._geo, 0.0)
        return np.array([fix.x_m, fix.y_m, fix.z_m])

    def jpeg(self, frame: int) -> bytes:
        """Return the image of a frame as JPEG; the frame must have one."""
        return encoded(self._camera.measurement(frame))

    def instances(self, frame: int) -> NDArray[np.uint16]:
        """Return the actor id at each pixel of the same image, shape (height, width)."""
        return instance_ids(self._instances.measurement(frame))

    def close(self) -> None:
        """Destroy all sensors."""
        for sensor in (self._lidar, self._imu, self._gnss, self._camera, self._instances):
            sensor.close()


def encoded(image: carla.Image, quality: int = JPEG_QUALITY) -> bytes:
    """Encode an image as JPEG, without chroma subsampling."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(camera_rgb(image)).save(file, "JPEG", quality=quality, subsampling=0)
    return file.getvalue()


def instance_ids(image: carla.Image) -> NDArray[np.uint16]:
    """Return the ids in an instance image, shape (height, width): green is the low byte, blue the high byte.

    carlette uses actor ids. CARLA uses its own object numbers, which cannot be mapped to actors.
    """
    pixels = camera_pixels(image)
    return np.asarray(pixels[:, :, 1] + pixels[:, :, 0] * np.uint16(256), np.uint16)
