"""The measurements of a vehicle in another process: requested on each tick, read from shared memory."""

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
from stucksolver_perception.carla.sensor_suite import EARLY_S, PICTURE_EVERY_S, TickMeasurements
from stucksolver_perception.measurements import CameraFrame, GnssFix, ImuSample, LidarSweep, WheelSpeed
from stucksolver_perception.rig import CameraRig, Rig

PIXEL = "B"
"""The format of a byte in `memoryview`."""
COORDINATE = "f"
"""The format of a single-precision number in `memoryview`."""
IMU_NUMBERS = 7
"""Numbers of an IMU sample: acceleration (3), angular velocity (3), compass."""
GNSS_NUMBERS = 3
"""Numbers of a GNSS fix: latitude, longitude, altitude."""
SPEED_NUMBERS = 1


class WorldClock(Protocol):
    """The mirrored world's time."""

    time_s: float

    def turn_to(self, tick: Mapping[str, Any]) -> None:
        """Another tick."""


class SharedMeasurements:
    """See `GivesMeasurements`. `ask` asks the other process; `clock` is set to the tick of the answer.

    `seed` is that of the wheels' noise; the noise of the other sensors is the evaluator's.
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
        """Return the newest measurements, of whichever tick.

        Raises:
            SensorError: The image or the sweep does not belong to this rig.
        """
        looks = self._clock.time_s >= self._next_picture_s - EARLY_S
        told = self._ask(ALL if looks else NO_PICTURE)
        if not isinstance(told, dict):
            raise SensorError("the agent's process gives no measurements; use the bridge that came with stucksolver")
        self._clock.turn_to(told["tick"])
        time_s = self._clock.time_s
        due = [LIDAR, IMU, GNSS, SPEED, *([CAMERA] if looks else [])]
        picture = self._picture(CAMERA, self._rig.camera, told[CAMERA], time_s)
        if picture is not None:
            self._next_picture_s = time_s + PICTURE_EVERY_S
        return TickMeasurements(
            sweep=self._sweep(told[LIDAR], time_s),
            picture=picture,
            imu=self._imu(told[IMU], time_s),
            fix=self._fix(told[GNSS], time_s),
            wheels=self._wheels(told[SPEED], time_s),
            silent=tuple(name for name in due if told[name] is None),
            rear=self._picture(REAR, self._rig.rear_camera, told.get(REAR), time_s),
        )

    def close(self) -> None:
        """Do nothing: the sensors belong to the other process."""
        self._memory.close()

    def _picture(
        self, name: str, camera: CameraRig | None, told: Mapping[str, Any] | None, time_s: float
    ) -> CameraFrame | None:
        if told is None or camera is None:
            return None
        shape = told["shape"]
        if len(shape) != 3 or tuple(shape[:2]) != (camera.height_px, camera.width_px) or shape[2] != 4:
            size = " x ".join(str(item) for item in (*shape[1::-1], *shape[2:])) or str(told["format"])
            raise SensorError(
                f"the {name}'s picture is {size}, the rig says {camera.width_px} x {camera.height_px} x 4 bytes: "
                f"give the rig file of this {name}"
            )
        pixels = self._array(name, told, PIXEL, np.dtype(np.uint8))
        raw: Any = SimpleNamespace(raw_data=pixels, height=shape[0], width=shape[1])
        return CameraFrame(time_s, camera_rgb(raw))

    def _sweep(self, told: Mapping[str, Any] | None, time_s: float) -> LidarSweep | None:
        if told is None:
            return None
        shape = told["shape"]
        if len(shape) != 2 or shape[1] != 4:
            raise SensorError(
                f"the LiDAR gives an array of shape {tuple(shape)}: expected (n, 4): x, y, z and intensity, as "
                "CARLA's leaderboard hands it to agents"
            )
        raw: Any = SimpleNamespace(raw_data=self._array("LiDAR", told, COORDINATE, np.dtype(np.float32)))
        return LidarSweep(time_s, lidar_points(raw, self._lidar_to_vehicle))

    def _array(self, name: str, told: Mapping[str, Any], form: str, dtype: np.dtype[Any]) -> NDArray[Any]:
        """Return a flat copy of an array in the shared memory."""
        if told["at"] is None:
            raise SensorError(f"the {name} gives {told['bytes']} bytes at once, more than the bridge takes")
        if told["format"] != form:
            raise SensorError(f"the {name} gives numbers of type {told['format']!r}, expected {form!r}")
        start, size = int(told["at"]), int(told["bytes"])
        return np.frombuffer(self._memory[start : start + size], dtype)

    def _imu(self, told: Sequence[float] | None, time_s: float) -> ImuSample | None:
        if told is None:
            return None
        ax, ay, az, gx, gy, gz, compass = _counted("IMU", told, IMU_NUMBERS)
        acceleration, rotation = SimpleNamespace(x=ax, y=ay, z=az), SimpleNamespace(x=gx, y=gy, z=gz)
        raw: Any = SimpleNamespace(accelerometer=acceleration, gyroscope=rotation, compass=compass)
        return imu_sample(raw, time_s)

    def _fix(self, told: Sequence[float] | None, time_s: float) -> GnssFix | None:
        if told is None:
            return None
        latitude, longitude, altitude = _counted("GNSS", told, GNSS_NUMBERS)
        raw: Any = SimpleNamespace(latitude=latitude, longitude=longitude, altitude=altitude)
        return gnss_fix(raw, self._geo, time_s)

    def _wheels(self, told: Sequence[float] | None, time_s: float) -> WheelSpeed:
        """Return the leaderboard's speedometer reading, or the last one if there is none."""
        if told is not None:
            (speed_mps,) = _counted("speedometer", told, SPEED_NUMBERS)
            self._speed_mps = wheel_speed_mps(speed_mps, self._rig.wheel_speed_noise_mps, self._random)
        return WheelSpeed(time_s, self._speed_mps)


def _counted(name: str, told: Sequence[float], count: int) -> tuple[float, ...]:
    if len(told) != count:
        raise SensorError(f"the {name} gives {len(told)} numbers, expected {count}, as from CARLA's leaderboard")
    return tuple(told)
