"""The rig's sensors on a vehicle in CARLA: attached by the client, read tick by tick, in our own frames."""

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

PICTURE_EVERY_S = 0.2
"""Lamps and lights change no faster than a few times a second."""
REAR_EVERY_S = 0.4
"""What comes up from behind is looked at several times before it is near."""
WAIT_S = 30.0
"""For a tick's data; the first images of a town take longest."""
MOST_BEHIND = 2
"""In a world that does not wait, a measurement this many ticks old is still used if there are newer ones, too."""
EARLY_S = 1e-6
"""Sums of ticks miss a multiple of a period by less than this."""


@dataclass(frozen=True, eq=False)
class TickMeasurements:
    """The sensors' data of one tick; None if a sensor was not due, or gave none."""

    sweep: LidarSweep | None
    picture: CameraFrame | None
    imu: ImuSample | None
    fix: GnssFix | None
    wheels: WheelSpeed
    silent: tuple[str, ...] = ()
    """Sensors that were due and gave no data."""
    rear: CameraFrame | None = None
    """The rear camera's image."""


class MeasurementSource(Protocol):
    """The sensors of a vehicle, wherever they are: `SensorSuite` on a client's vehicle, or another process's."""

    def read(self) -> TickMeasurements:
        """Return the measurements of the world's present tick.

        Raises:
            SensorError: The image or the sweep does not belong to this rig.
        """

    def close(self) -> None:
        """Destroy the sensors."""


class SensorSuite:
    """Call `read` once after each tick of the world, and `close` at the end.

    `seed` is that of the noise of all sensors. With `waits`, `read` waits for each tick's data, in a world that waits
    for us. Otherwise it returns what has arrived.

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
        picture_every_s: float = PICTURE_EVERY_S,
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
            self._put("LiDAR", lidar_setup(rig, seed))
            self._put("camera", camera_setup(rig.camera, picture_every_s))
            if rig.rear_camera is not None:
                self._put("rear camera", camera_setup(rig.rear_camera, REAR_EVERY_S))
            self._put("IMU", imu_setup(rig, seed))
            self._put("GNSS", gnss_setup(rig, seed))
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

    def _put(self, name: str, setup: SensorSetup) -> None:
        actor = mount_sensor(self._vehicle, setup)
        self._sensors[name] = _SensorQueue(actor, setup.attributes.get("sensor_tick", 0.0))

    def _sweep(self, raw: carla.LidarMeasurement, time_s: float) -> LidarSweep:
        told: Any = raw  # the client's stub lacks `channels`
        if int(told.channels) != self._rig.lidar.channels:
            raise SensorError(
                f"the LiDAR has {told.channels} channels, the rig says {self._rig.lidar.channels}: "
                "give the rig file of this LiDAR, and weights trained for it"
            )
        return LidarSweep(time_s, lidar_points(raw, self._lidar_to_vehicle))

    def _picture(
        self, name: str, camera: CameraRig | None, raw: Mapping[str, Any], time_s: float
    ) -> CameraFrame | None:
        image = raw.get(name)
        if image is None or camera is None:
            return None
        wanted = (camera.width_px, camera.height_px)
        if (image.width, image.height) != wanted:
            raise SensorError(
                f"the {name}'s picture is {image.width} x {image.height}, the rig says {wanted[0]} x {wanted[1]}: "
                f"give the rig file of this {name}"
            )
        return CameraFrame(time_s, camera_rgb(image))

    def _wheels(self, time_s: float) -> WheelSpeed:
        """Like the leaderboard's speedometer this is the client's velocity, with our noise."""
        velocity, ahead = self._vehicle.get_velocity(), self._vehicle.get_transform().get_forward_vector()
        speed_mps = velocity.x * ahead.x + velocity.y * ahead.y + velocity.z * ahead.z
        return WheelSpeed(time_s, wheel_speed_mps(speed_mps, self._rig.wheel_speed_noise_mps, self._random))


class _SensorQueue:
    """One sensor's data by frame."""

    def __init__(self, actor: Any, period_s: float) -> None:
        self._actor = actor
        self._period_s = period_s
        self._came: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._held: Any | None = None
        self._due_s: float | None = None
        actor.listen(self._came.put)

    def is_due(self, time_s: float) -> bool:
        """True if it should have measured by now: once per period from its first measurement on."""
        return self._due_s is None or time_s >= self._due_s - EARLY_S

    def take(self, frame: int, time_s: float, until: float) -> Any | None:
        """Return the measurement of a frame, waiting until then if it is due; None if there is none."""
        while True:
            if self._held is None:
                left = until - time.monotonic()
                due = self.is_due(time_s)
                try:
                    self._held = self._came.get(timeout=left) if due and left > 0.0 else self._came.get_nowait()
                except queue.Empty:
                    if due:
                        self._due_s = None
                    return None
            if int(self._held.frame) > frame:
                return None
            found, self._held = self._held, None
            behind = frame - int(found.frame)
            # A reader slower than the world's ticks skips some, otherwise it would fall further and further behind.
            is_fresh = behind <= MOST_BEHIND or self._came.empty()
            if behind == 0 or (is_fresh and time.monotonic() >= until):
                self._note(float(found.timestamp))
                return found

    def _note(self, time_s: float) -> None:
        if self._due_s is None:
            self._due_s = time_s
        # If ticks do not divide the period it comes late, but the next one is not later for that.
        self._due_s = max(self._due_s + self._period_s, time_s)

    def close(self) -> None:
        """Destroy it; the simulator may be gone already."""
        with contextlib.suppress(RuntimeError):
            self._actor.stop()
            self._actor.destroy()
