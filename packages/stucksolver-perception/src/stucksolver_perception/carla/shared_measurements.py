"""Requests the measurements of a vehicle in another process on each tick, and reads them from shared memory."""

from __future__ import annotations

import math
import mmap
from collections.abc import Callable, Mapping, Sequence
from types import SimpleNamespace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from stucksolver_bridge.sensor_data import ALL, CAMERA, GNSS, IMU, LIDAR, NO_PICTURE, REAR, SPEED
from stucksolver_carla.perception_interface import SensorError
from stucksolver_perception.carla.georeference import GeoReference
from stucksolver_perception.carla.sensor_conversion import (
    camera_rgb,
    gnss_fix,
    imu_sample,
    lidar_points,
    wheel_speed_mps,
)
from stucksolver_perception.carla.sensor_suite import PICTURE_PERIOD_S, TIME_TOLERANCE_S, TickMeasurements
from stucksolver_perception.measurements import CameraFrame, GnssFix, ImuSample, LidarSweep, WheelSpeed
from stucksolver_perception.rig import CameraRig, Rig

PIXEL = "B"
"""Format of a byte in `memoryview`."""
COORDINATE = "f"
"""Format of a single-precision number in `memoryview`."""
IMU_NUMBERS = 7
"""Number of values of an IMU sample: acceleration (3), angular velocity (3), compass."""
GNSS_NUMBERS = 3
"""Number of values of a GNSS fix: latitude, longitude, altitude."""
SPEED_NUMBERS = 1
"""Number of values of the speedometer."""


class WorldClock(Protocol):
    """The mirrored world's time."""

    time_s: float

    def start_tick(self, tick: Mapping[str, Any]) -> None:
        """Start another tick."""


class SharedMeasurements:
    """A `MeasurementSource` of another process. `ask` sends it a request; `clock` is set to the tick of the answer.

    `seed` is the seed of the wheels' noise. The evaluator adds the noise of the other sensors.
    """

    def __init__(
        self, opening: Mapping[str, Any], rig: Rig, ask: Callable[[str], Any], clock: WorldClock, seed: int = 0
    ) -> None:
        self._memory = mmap.mmap(int(opening["frames"]["fd"]), int(opening["frames"]["size"]), prot=mmap.PROT_READ)
        self._rig, self._ask, self._clock = rig, ask, clock
        self._geo = GeoReference(str(opening["xodr"]))
        self._lidar_to_vehicle = rig.lidar.mount.to_vehicle()
        self._random = np.random.default_rng(seed)
        self._next_picture_s = -math.inf
        self._speed_mps = 0.0

    def read(self) -> TickMeasurements:
        """Return the newest measurements, of any tick.

        Raises:
            SensorError: The image or the sweep does not belong to this rig.
        """
        wants_picture = self._clock.time_s >= self._next_picture_s - TIME_TOLERANCE_S
        data = self._ask(ALL if wants_picture else NO_PICTURE)
        if not isinstance(data, dict):
            raise SensorError("the agent's process gives no measurements; use the bridge of the same release")
        self._clock.start_tick(data["tick"])
        time_s = self._clock.time_s
        due = [LIDAR, IMU, GNSS, SPEED, *([CAMERA] if wants_picture else [])]
        picture = self._picture(CAMERA, self._rig.camera, data[CAMERA], time_s)
        if picture is not None:
            self._next_picture_s = time_s + PICTURE_PERIOD_S
        return TickMeasurements(
            sweep=self._sweep(data[LIDAR], time_s),
            picture=picture,
            imu=self._imu(data[IMU], time_s),
            fix=self._fix(data[GNSS], time_s),
            wheels=self._wheels(data[SPEED], time_s),
            silent=tuple(name for name in due if data[name] is None),
            rear=self._picture(REAR, self._rig.rear_camera, data.get(REAR), time_s),
        )

    def close(self) -> None:
        """Close the shared memory. The sensors belong to the other process."""
        self._memory.close()

    def _picture(
        self, name: str, camera: CameraRig | None, data: Mapping[str, Any] | None, time_s: float
    ) -> CameraFrame | None:
        if data is None or camera is None:
            return None
        shape = data["shape"]
        if len(shape) != 3 or tuple(shape[:2]) != (camera.height_px, camera.width_px) or shape[2] != 4:
            size = " x ".join(str(item) for item in (*shape[1::-1], *shape[2:])) or str(data["format"])
            raise SensorError(
                f"the {name}'s image is {size}, the rig has {camera.width_px} x {camera.height_px} x 4 bytes: "
                f"give the rig file of this {name}"
            )
        pixels = self._array(name, data, PIXEL, np.dtype(np.uint8))
        raw: Any = SimpleNamespace(raw_data=pixels, height=shape[0], width=shape[1])
        return CameraFrame(time_s, camera_rgb(raw))

    def _sweep(self, data: Mapping[str, Any] | None, time_s: float) -> LidarSweep | None:
        if data is None:
            return None
        shape = data["shape"]
        if len(shape) != 2 or shape[1] != 4:
            raise SensorError(
                f"the LiDAR gives an array of shape {tuple(shape)}; expected (n, 4): x, y, z and intensity, as from "
                "CARLA's leaderboard"
            )
        raw: Any = SimpleNamespace(raw_data=self._array("LiDAR", data, COORDINATE, np.dtype(np.float32)))
        return LidarSweep(time_s, lidar_points(raw, self._lidar_to_vehicle))

    def _array(self, name: str, data: Mapping[str, Any], form: str, dtype: np.dtype[Any]) -> NDArray[Any]:
        """Return a flat copy of an array in the shared memory."""
        if data["at"] is None:
            raise SensorError(f"the {name} gives {data['bytes']} bytes at once, more than the bridge's memory for it")
        if data["format"] != form:
            raise SensorError(f"the {name} gives numbers of type {data['format']!r}; expected {form!r}")
        start, size = int(data["at"]), int(data["bytes"])
        return np.frombuffer(self._memory[start : start + size], dtype)

    def _imu(self, data: Sequence[float] | None, time_s: float) -> ImuSample | None:
        if data is None:
            return None
        ax, ay, az, gx, gy, gz, compass = _checked_numbers("IMU", data, IMU_NUMBERS)
        acceleration, rotation = SimpleNamespace(x=ax, y=ay, z=az), SimpleNamespace(x=gx, y=gy, z=gz)
        raw: Any = SimpleNamespace(accelerometer=acceleration, gyroscope=rotation, compass=compass)
        return imu_sample(raw, time_s)

    def _fix(self, data: Sequence[float] | None, time_s: float) -> GnssFix | None:
        if data is None:
            return None
        latitude, longitude, altitude = _checked_numbers("GNSS", data, GNSS_NUMBERS)
        raw: Any = SimpleNamespace(latitude=latitude, longitude=longitude, altitude=altitude)
        return gnss_fix(raw, self._geo, time_s)

    def _wheels(self, data: Sequence[float] | None, time_s: float) -> WheelSpeed:
        """Return the speed of the leaderboard's speedometer; without a new value, the last one."""
        if data is not None:
            (speed_mps,) = _checked_numbers("speedometer", data, SPEED_NUMBERS)
            self._speed_mps = wheel_speed_mps(speed_mps, self._rig.wheel_speed_noise_mps, self._random)
        return WheelSpeed(time_s, self._speed_mps)


def _checked_numbers(name: str, data: Sequence[float], count: int) -> tuple[float, ...]:
    if len(data) != count:
        raise SensorError(f"the {name} gives {len(data)} numbers; expected {count}, as from CARLA's leaderboard")
    return tuple(data)
