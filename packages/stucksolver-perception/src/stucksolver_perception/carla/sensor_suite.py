"""Attaches the rig's sensors to a vehicle in CARLA, and reads them on each tick in the package's frames."""

from __future__ import annotations

import contextlib
import queue
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from stucksolver_carla.perception_interface import SensorError
from stucksolver_perception.carla.georeference import GeoReference
from stucksolver_perception.carla.sensor_conversion import (
    camera_rgb,
    gnss_fix,
    imu_sample,
    lidar_points,
    wheel_speed_mps,
)
from stucksolver_perception.carla.sensor_mounting import (
    SensorSetup,
    camera_setup,
    gnss_setup,
    imu_setup,
    lidar_setup,
    mount_sensor,
)
from stucksolver_perception.measurements import CameraFrame, GnssFix, ImuSample, LidarSweep, WheelSpeed
from stucksolver_perception.rig import CameraRig, Rig

if TYPE_CHECKING:
    import carla

PICTURE_PERIOD_S = 0.2
"""Time between two front images (s), because lamps and lights change only a few times per second. Ours."""
REAR_PERIOD_S = 0.4
"""Time between two rear images (s). It gives several images of an approaching vehicle before it is near. Ours."""
WAIT_S = 30.0
"""Time limit for a tick's data (s). The first images of a town take longest. Ours."""
MAX_LATE_TICKS = 2
"""Maximum age of a measurement that is used although newer ones exist, in a world that does not wait (ticks). Ours."""
TIME_TOLERANCE_S = 1e-6
"""Tolerance of time comparisons (s): sums of ticks have rounding errors."""


@dataclass(frozen=True, eq=False)
class TickMeasurements:
    """The sensors' data of one tick; None if a sensor was not due, or gave no data."""

    sweep: LidarSweep | None
    picture: CameraFrame | None
    imu: ImuSample | None
    fix: GnssFix | None
    wheels: WheelSpeed
    silent: tuple[str, ...] = ()
    """Names of the sensors that were due and gave no data."""
    rear: CameraFrame | None = None
    """The rear camera's image."""


class MeasurementSource(Protocol):
    """Source of a vehicle's measurements: `SensorSuite` on a client's vehicle, or the sensors of another process."""

    def read(self) -> TickMeasurements:
        """Return the measurements of the world's present tick.

        Raises:
            SensorError: The image or the sweep does not belong to this rig.
        """

    def close(self) -> None:
        """Destroy the sensors."""


class SensorSuite:
    """The attached sensors. Call `read` once after each tick of the world, and `close` at the end.

    `seed` is the seed of the noise of all sensors. With `waits`, `read` waits for each tick's data, in a world that
    waits. Otherwise it returns the data that have arrived.

    Raises:
        SensorError: A sensor cannot be attached.
    """

    def __init__(
        self,
        vehicle: carla.Vehicle,
        carla_map: carla.Map,
        rig: Rig,
        *,
        waits: bool = True,
        seed: int = 0,
        picture_period_s: float = PICTURE_PERIOD_S,
    ) -> None:
        self._world = vehicle.get_world()
        self._vehicle = vehicle
        self._rig = rig
        self._waits = waits
        self._random = np.random.default_rng(seed)
        self._geo = GeoReference(carla_map.to_opendrive())
        self._lidar_to_vehicle = rig.lidar.mount.to_vehicle()
        self._sensors: dict[str, _SensorQueue] = {}
        try:
            self._attach("LiDAR", lidar_setup(rig, seed))
            self._attach("camera", camera_setup(rig.camera, picture_period_s))
            if rig.rear_camera is not None:
                self._attach("rear camera", camera_setup(rig.rear_camera, REAR_PERIOD_S))
            self._attach("IMU", imu_setup(rig, seed))
            self._attach("GNSS", gnss_setup(rig, seed))
        except SensorError:
            self.close()
            raise

    def read(self) -> TickMeasurements:
        """Return the measurements of the world's present tick.

        Raises:
            SensorError: The image or the sweep does not belong to this rig.
        """
        snapshot = self._world.get_snapshot()
        frame = int(snapshot.frame)
        time_s = float(snapshot.timestamp.elapsed_seconds)
        until = time.monotonic() + (WAIT_S if self._waits else 0.0)
        raw = {name: sensor.take(frame, time_s, until) for name, sensor in self._sensors.items()}
        silent = tuple(name for name, sensor in self._sensors.items() if raw[name] is None and sensor.is_due(time_s))
        return TickMeasurements(
            sweep=None if raw["LiDAR"] is None else self._sweep(raw["LiDAR"], time_s),
            picture=self._picture("camera", self._rig.camera, raw, time_s),
            imu=None if raw["IMU"] is None else imu_sample(raw["IMU"], time_s),
            fix=None if raw["GNSS"] is None else gnss_fix(raw["GNSS"], self._geo, time_s),
            wheels=self._wheels(time_s),
            silent=silent,
            rear=self._picture("rear camera", self._rig.rear_camera, raw, time_s),
        )

    def close(self) -> None:
        """Destroy the sensors."""
        for sensor in self._sensors.values():
            sensor.close()
        self._sensors.clear()

    def _attach(self, name: str, setup: SensorSetup) -> None:
        actor = mount_sensor(self._vehicle, setup)
        self._sensors[name] = _SensorQueue(actor, setup.attributes.get("sensor_tick", 0.0))

    def _sweep(self, raw: carla.LidarMeasurement, time_s: float) -> LidarSweep:
        lidar: Any = raw  # the client's stub lacks `channels`
        if int(lidar.channels) != self._rig.lidar.channels:
            raise SensorError(
                f"the LiDAR has {lidar.channels} channels, the rig has {self._rig.lidar.channels}: "
                "give the rig file of this LiDAR, and weights trained for it"
            )
        return LidarSweep(time_s, lidar_points(raw, self._lidar_to_vehicle))

    def _picture(
        self, name: str, camera: CameraRig | None, raw: Mapping[str, Any], time_s: float
    ) -> CameraFrame | None:
        image = raw.get(name)
        if image is None or camera is None:
            return None
        expected = (camera.width_px, camera.height_px)
        if (image.width, image.height) != expected:
            raise SensorError(
                f"the {name}'s image is {image.width} x {image.height}, the rig has {expected[0]} x {expected[1]}: "
                f"give the rig file of this {name}"
            )
        return CameraFrame(time_s, camera_rgb(image))

    def _wheels(self, time_s: float) -> WheelSpeed:
        """Return the client's velocity with the rig's noise, like the leaderboard's speedometer."""
        velocity, ahead = self._vehicle.get_velocity(), self._vehicle.get_transform().get_forward_vector()
        speed_mps = velocity.x * ahead.x + velocity.y * ahead.y + velocity.z * ahead.z
        return WheelSpeed(time_s, wheel_speed_mps(speed_mps, self._rig.wheel_speed_noise_mps, self._random))


class _SensorQueue:
    """One sensor's data by frame."""

    def __init__(self, actor: Any, period_s: float) -> None:
        self._actor = actor
        self._period_s = period_s
        self._received: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._pending: Any | None = None
        self._due_s: float | None = None
        actor.listen(self._received.put)

    def is_due(self, time_s: float) -> bool:
        """Return True if a measurement is due: once per period, starting with the first measurement."""
        return self._due_s is None or time_s >= self._due_s - TIME_TOLERANCE_S

    def take(self, frame: int, time_s: float, until: float) -> Any | None:
        """Return the measurement of a frame; None without one. Wait for it up to `until` if it is due."""
        while True:
            if self._pending is None:
                remaining_s = until - time.monotonic()
                due = self.is_due(time_s)
                try:
                    self._pending = (
                        self._received.get(timeout=remaining_s)
                        if due and remaining_s > 0.0
                        else self._received.get_nowait()
                    )
                except queue.Empty:
                    if due:
                        self._due_s = None
                    return None
            if int(self._pending.frame) > frame:
                return None
            data, self._pending = self._pending, None
            late_ticks = frame - int(data.frame)
            # A reader that is slower than the world's ticks must skip some, or its data would get older and older.
            is_fresh = late_ticks <= MAX_LATE_TICKS or self._received.empty()
            if late_ticks == 0 or (is_fresh and time.monotonic() >= until):
                self._set_next_due(float(data.timestamp))
                return data

    def _set_next_due(self, time_s: float) -> None:
        if self._due_s is None:
            self._due_s = time_s
        # If ticks do not divide the period, a measurement comes late. That must not delay the next one.
        self._due_s = max(self._due_s + self._period_s, time_s)

    def close(self) -> None:
        """Destroy the sensor."""
        # The simulator may have ended already. Then there is nothing to destroy.
        with contextlib.suppress(RuntimeError):
            self._actor.stop()
            self._actor.destroy()
