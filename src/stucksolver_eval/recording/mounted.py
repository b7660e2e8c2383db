"""The rig's sensors on a vehicle in CARLA for a recording: all data of each tick, in the frames of our perception."""

from __future__ import annotations

import contextlib
import io
import queue
import time
from typing import Any

import carla
import numpy as np
from numpy.typing import NDArray

from stucksolver.perception.measurements import Floats, Singles
from stucksolver.perception.rig import Rig
from stucksolver.stacks.sensed.georeference import GeoReference
from stucksolver.stacks.sensed.mounting import (
    SensorError,
    SensorSetup,
    camera_setup,
    gnss_setup,
    imu_setup,
    lidar_setup,
    mount_sensor,
)
from stucksolver.stacks.sensed.readings import camera_pixels, camera_rgb, gnss_fix, imu_sample, lidar_points

DATA_LIMIT_S = 60.0
"""For a sensor's data of one tick; the first pictures of a town take longest."""
JPEG_QUALITY = 95
"""And colours are not thinned out: a lamp is a few pixels, and a vehicle gets raw pictures."""
INSTANCE_CAMERA = "sensor.camera.instance_segmentation"


class MountedSensor:
    """One sensor of the simulator; its measurements wait here, each with the number of its frame."""

    def __init__(self, hero: carla.Vehicle, setup: SensorSetup) -> None:
        self.type_id = setup.type_id
        self._data: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._actor = mount_sensor(hero, setup)
        self._actor.listen(self._data.put)

    def of(self, frame: int) -> Any:
        """The measurement of a frame; older ones are dropped. Raises `SensorError` where it does not come."""
        until_s = time.monotonic() + DATA_LIMIT_S
        while True:
            try:
                data = self._data.get(timeout=max(until_s - time.monotonic(), 0.0))
            except queue.Empty:
                raise SensorError(
                    f"{self.type_id} sent no data for frame {frame} in {DATA_LIMIT_S:.0f} s; run again"
                ) from None
            if data.frame == frame:
                return data
            if data.frame > frame:
                raise SensorError(f"{self.type_id} left frame {frame} out; run again")

    def first_frame(self) -> int | None:
        """The frame of the oldest measurement that waits, which is dropped; None where none does."""
        with contextlib.suppress(queue.Empty):
            return int(self._data.get_nowait().frame)
        return None

    def close(self) -> None:
        """Take it off. The simulator may be gone already."""
        with contextlib.suppress(RuntimeError):
            self._actor.stop()
            self._actor.destroy()


class RecordingSensors:
    """All sensors of a rig on one vehicle, with an instance camera beside the camera.

    `picture_period_s`: between two pictures. `seed`: of the noise of LiDAR, IMU and GNSS. Raises `SensorError`.
    """

    def __init__(self, hero: carla.Vehicle, rig: Rig, carla_map: carla.Map, picture_period_s: float, seed: int) -> None:
        self._geo = GeoReference(carla_map.to_opendrive())
        self._to_vehicle = rig.lidar.mount.to_vehicle()
        self._lidar = MountedSensor(hero, lidar_setup(rig, seed))
        self._imu = MountedSensor(hero, imu_setup(rig, seed))
        self._gnss = MountedSensor(hero, gnss_setup(rig, seed))
        self._camera = MountedSensor(hero, camera_setup(rig, picture_period_s))
        self._instances = MountedSensor(hero, camera_setup(rig, picture_period_s, INSTANCE_CAMERA))

    def first_picture(self) -> int | None:
        """The frame of the first picture, once it has come; the next ones follow at the period."""
        return self._camera.first_frame()

    def points(self, frame: int) -> Singles:
        """(n, 4): the sweep of a frame in the vehicle frame, and its intensities."""
        return lidar_points(self._lidar.of(frame), self._to_vehicle)

    def imu(self, frame: int) -> Floats:
        """(7,): accelerations, turn rates and compass of a frame, as `Recorded.imu`."""
        sample = imu_sample(self._imu.of(frame), 0.0)
        return np.array([*sample.acceleration_mps2, *sample.rotation_rps, sample.compass_rad], np.float64)

    def gnss(self, frame: int) -> Floats:
        """(3,): the fix of a frame in the local frame."""
        fix = gnss_fix(self._gnss.of(frame), self._geo, 0.0)
        return np.array([fix.x_m, fix.y_m, fix.z_m])

    def jpeg(self, frame: int) -> bytes:
        """The picture of a frame that has one."""
        return encoded(self._camera.of(frame))

    def instances(self, frame: int) -> NDArray[np.uint16]:
        """(height, width): the actor's id at each pixel of the same picture."""
        return instance_ids(self._instances.of(frame))

    def close(self) -> None:
        """Take all of them off."""
        for sensor in (self._lidar, self._imu, self._gnss, self._camera, self._instances):
            sensor.close()


def encoded(image: carla.Image) -> bytes:
    """A picture as a JPEG."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(camera_rgb(image)).save(file, "JPEG", quality=JPEG_QUALITY, subsampling=0)
    return file.getvalue()


def instance_ids(image: carla.Image) -> NDArray[np.uint16]:
    """(height, width): an id's low byte is the picture's green, its high one the blue.

    carlette's are ids of actors. CARLA numbers its objects itself: there nothing can be made of them.
    """
    pixels = camera_pixels(image)
    return np.asarray(pixels[:, :, 1] + pixels[:, :, 0] * np.uint16(256), np.uint16)
