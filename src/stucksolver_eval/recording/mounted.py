"""The rig's sensors on a vehicle in CARLA for a recording: all data of each tick, in the frames of our perception.

CARLA measures in a left-handed frame (x ahead, y right, z up). A vector is turned over by its y. A turn rate is a
pseudovector of that frame (v = w x r), so that its x and z change their signs instead.
"""

from __future__ import annotations

import contextlib
import io
import math
import queue
import time
from collections.abc import Mapping
from typing import Any

import carla
import numpy as np
from numpy.typing import NDArray

from stucksolver.perception.measurements import Floats, Singles
from stucksolver.perception.rig import Mount, Rig
from stucksolver_eval.recording.geodetic import EARTH_RADIUS_M, GeoReference

DATA_LIMIT_S = 60.0
"""For a sensor's data of one tick; the first pictures of a town take longest."""
JPEG_QUALITY = 95
"""And colours are not thinned out: a lamp is a few pixels, and a vehicle gets raw pictures."""
_PLACE = Mount(x_m=0.0, y_m=0.0, z_m=0.0)
"""GNSS and IMU sit at the vehicle's reference point."""


class RecordingSensorError(RuntimeError):
    """A sensor is missing here, or it is silent; the message names it."""


class MountedSensor:
    """One sensor of the simulator; its measurements wait here, each with the number of its frame."""

    def __init__(self, hero: carla.Vehicle, type_id: str, mount: Mount, attributes: Mapping[str, float]) -> None:
        world, self.type_id = hero.get_world(), type_id
        found = list(world.get_blueprint_library().filter(type_id))
        if not found:
            raise RecordingSensorError(f"this simulator has no {type_id}; use carlette, or CARLA 0.9.14 or later")
        for name, value in attributes.items():
            found[0].set_attribute(name, str(value))
        self._data: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._actor = world.spawn_actor(found[0], placed(mount), attach_to=hero)
        self._actor.listen(self._data.put)

    def of(self, frame: int) -> Any:
        """The measurement of a frame; older ones are dropped. Raises `RecordingSensorError` where it does not come."""
        until_s = time.monotonic() + DATA_LIMIT_S
        while True:
            try:
                data = self._data.get(timeout=max(until_s - time.monotonic(), 0.0))
            except queue.Empty:
                raise RecordingSensorError(
                    f"{self.type_id} gave nothing for frame {frame} in {DATA_LIMIT_S:.0f} s; run again"
                ) from None
            if data.frame == frame:
                return data
            if data.frame > frame:
                raise RecordingSensorError(f"{self.type_id} left frame {frame} out; run again")

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

    `picture_period_s`: between two pictures. `seed`: of the sensors' noise. Raises `RecordingSensorError`.
    """

    def __init__(self, hero: carla.Vehicle, rig: Rig, carla_map: carla.Map, picture_period_s: float, seed: int) -> None:
        self._geo = GeoReference(carla_map.to_opendrive())
        self._to_vehicle = rig.lidar.mount.to_vehicle()
        lens = {
            "image_size_x": rig.camera.width_px,
            "image_size_y": rig.camera.height_px,
            "fov": rig.camera.fov_deg,
            "sensor_tick": picture_period_s,
        }
        at = rig.camera.mount
        self._lidar = MountedSensor(hero, "sensor.lidar.ray_cast", rig.lidar.mount, _lidar_attributes(rig))
        self._imu = MountedSensor(hero, "sensor.other.imu", _PLACE, _imu_attributes(rig, seed))
        self._gnss = MountedSensor(hero, "sensor.other.gnss", _PLACE, _gnss_attributes(rig, seed))
        self._camera = MountedSensor(hero, "sensor.camera.rgb", at, lens)
        self._instances = MountedSensor(hero, "sensor.camera.instance_segmentation", at, lens)

    def first_picture(self) -> int | None:
        """The frame of the first picture, once it has come; the next ones follow at the period."""
        return self._camera.first_frame()

    def points(self, frame: int) -> Singles:
        """(n, 4): the sweep of a frame in the vehicle frame, and its intensities."""
        return lidar_points(self._lidar.of(frame).raw_data, self._to_vehicle)

    def imu(self, frame: int) -> Floats:
        """(7,): accelerations, turn rates and compass of a frame, as `Recorded.imu`."""
        data = self._imu.of(frame)
        a, w = data.accelerometer, data.gyroscope
        return imu_row((a.x, a.y, a.z), (w.x, w.y, w.z), data.compass)

    def gnss(self, frame: int) -> Floats:
        """(3,): the fix of a frame in the local frame."""
        data = self._gnss.of(frame)
        x, y = self._geo.local(data.latitude, data.longitude)
        return np.array([x, y, data.altitude])

    def jpeg(self, frame: int) -> bytes:
        """The picture of a frame that has one."""
        image = self._camera.of(frame)
        return encoded(image.raw_data, image.height, image.width)

    def instances(self, frame: int) -> NDArray[np.uint16]:
        """(height, width): the actor's id at each pixel of the same picture."""
        image = self._instances.of(frame)
        return instance_ids(image.raw_data, image.height, image.width)

    def close(self) -> None:
        """Take all of them off."""
        for sensor in (self._lidar, self._imu, self._gnss, self._camera, self._instances):
            sensor.close()


def placed(mount: Mount) -> carla.Transform:
    """A mount as a `carla.Transform`, whose yaw is positive to the right and whose pitch is positive up."""
    return carla.Transform(
        carla.Location(mount.x_m, -mount.y_m, mount.z_m),
        carla.Rotation(pitch=-mount.pitch_deg, yaw=-mount.yaw_deg, roll=mount.roll_deg),
    )


def lidar_points(raw: Any, to_vehicle: Floats) -> Singles:
    """CARLA's rows (x, y, z, intensity; left-handed, the sensor's frame) in the vehicle frame."""
    points = np.frombuffer(raw, dtype=np.float32).reshape(-1, 4).copy()
    points[:, 1] *= -1.0
    turn, shift = to_vehicle[:3, :3].astype(np.float32), to_vehicle[:3, 3].astype(np.float32)
    points[:, :3] = points[:, :3] @ turn.T + shift
    return np.asarray(points)


def imu_row(
    acceleration: tuple[float, float, float], turning: tuple[float, float, float], compass_rad: float
) -> Floats:
    """Of CARLA's vectors; its compass is 0 to the north (the local frame's y) and grows to the east."""
    yaw = math.remainder(math.pi / 2.0 - compass_rad, math.tau)
    (ax, ay, az), (wx, wy, wz) = acceleration, turning
    return np.array([ax, -ay, az, -wx, wy, -wz, yaw], dtype=np.float64)


def encoded(raw: Any, height: int, width: int) -> bytes:
    """A picture in BGRA as a JPEG."""
    from PIL import Image

    picture = Image.frombuffer("RGB", (width, height), bytes(raw), "raw", "BGRX", 0, 1)
    file = io.BytesIO()
    picture.save(file, "JPEG", quality=JPEG_QUALITY, subsampling=0)
    return file.getvalue()


def instance_ids(raw: Any, height: int, width: int) -> NDArray[np.uint16]:
    """(height, width): of a picture in BGRA, whose green is an id's low byte and whose blue is its high one.

    carlette's are ids of actors. CARLA numbers its objects itself: there nothing can be made of them.
    """
    pixels = np.frombuffer(raw, dtype=np.uint8).reshape(height, width, 4)
    return np.asarray(pixels[:, :, 1] + pixels[:, :, 0] * np.uint16(256), np.uint16)


def _lidar_attributes(rig: Rig) -> dict[str, float]:
    lidar = rig.lidar
    return {
        "channels": lidar.channels,
        "range": lidar.range_m,
        "rotation_frequency": lidar.turns_per_s,
        "points_per_second": lidar.points_per_s,
        "upper_fov": lidar.upper_deg,
        "lower_fov": lidar.lower_deg,
        "atmosphere_attenuation_rate": lidar.attenuation_per_m,
        "dropoff_general_rate": lidar.dropoff_general,
        "dropoff_intensity_limit": lidar.dropoff_intensity_limit,
        "dropoff_zero_intensity": lidar.dropoff_zero_intensity,
        "noise_stddev": lidar.noise_m,
    }


def _imu_attributes(rig: Rig, seed: int) -> dict[str, float]:
    noise = {f"noise_accel_stddev_{axis}": rig.imu_acceleration_noise_mps2 for axis in "xyz"}
    noise |= {f"noise_gyro_stddev_{axis}": rig.imu_rotation_noise_rps for axis in "xyz"}
    return {**noise, "noise_seed": seed}


def _gnss_attributes(rig: Rig, seed: int) -> dict[str, float]:
    degrees = math.degrees(rig.gnss_noise_m / EARTH_RADIUS_M)
    noise = {"noise_lat_stddev": degrees, "noise_lon_stddev": degrees, "noise_alt_stddev": rig.gnss_noise_m}
    return {**noise, "noise_seed": seed}
