"""The rig's sensors on a vehicle in CARLA: put up through the client, read tick by tick, in our own frames."""

from __future__ import annotations

import math
import queue
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stucksolver.perception.measurements import CameraFrame, GnssFix, ImuSample, LidarSweep, Singles, WheelSpeed
from stucksolver.perception.rig import Mount, Rig
from stucksolver.stacks.sensed.georeference import EARTH_RADIUS_M, GeoReference

if TYPE_CHECKING:
    import carla

PICTURE_EVERY_S = 0.2
"""Lamps and lights change no quicker than a few times a second."""
STANDS_MPS = 0.02
"""Slower, no tooth of a wheel's counter passes between two ticks."""
WAIT_S = 30.0
"""For a tick's data; the first pictures of a town take longest."""


class SensorError(RuntimeError):
    """A sensor of the rig cannot be put up, or says nothing; the message names it and the remedy."""


@dataclass(frozen=True, eq=False)
class Measured:
    """What the sensors said in one tick; None where a sensor was not due, or is silent."""

    sweep: LidarSweep | None
    picture: CameraFrame | None
    imu: ImuSample | None
    fix: GnssFix | None
    wheels: WheelSpeed
    silent: tuple[str, ...] = ()
    """Sensors that were due and said nothing."""


class SensorSuite:
    """Call `read` once after each tick of the world, `close` in the end. Raises `SensorError`.

    `seed` is of the wheels' noise; the other sensors' is the simulator's. With `waits` each tick's data are waited
    for, as in a world that waits for us; without, what has come is taken.
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
        self._lidar_to_vehicle = rig.lidar.mount.to_vehicle().astype(np.float32)
        self._sensors: dict[str, _Sensor] = {}
        lidar, camera = rig.lidar, rig.camera
        try:
            self._put(
                "LiDAR",
                "sensor.lidar.ray_cast",
                lidar.mount,
                {
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
                },
            )
            size = {"image_size_x": camera.width_px, "image_size_y": camera.height_px, "fov": camera.fov_deg}
            self._put("camera", "sensor.camera.rgb", camera.mount, {**size, "sensor_tick": picture_every_s})
            centre, noise = Mount(x_m=0.0, y_m=0.0, z_m=0.0), rig.imu_acceleration_noise_mps2
            turning = rig.imu_rotation_noise_rps
            shaken = {f"noise_accel_stddev_{axis}": noise for axis in "xyz"}
            shaken |= {f"noise_gyro_stddev_{axis}": turning for axis in "xyz"}
            self._put("IMU", "sensor.other.imu", centre, shaken)
            degrees = math.degrees(rig.gnss_noise_m / EARTH_RADIUS_M)
            self._put("GNSS", "sensor.other.gnss", centre, {"noise_lat_stddev": degrees, "noise_lon_stddev": degrees})
        except SensorError:
            self.close()
            raise

    def read(self) -> Measured:
        """Of the world's present tick. Raises `SensorError` where the picture has another size than the rig's."""
        snapshot = self._world.get_snapshot()
        frame = int(snapshot.frame)
        time_s = float(snapshot.timestamp.elapsed_seconds)
        until = time.monotonic() + (WAIT_S if self._waits else 0.0)
        raw = {name: sensor.take(frame, until) for name, sensor in self._sensors.items()}
        silent = tuple(name for name, sensor in self._sensors.items() if raw[name] is None and sensor.is_due(frame))
        return Measured(
            sweep=None if raw["LiDAR"] is None else LidarSweep(time_s, self._points(raw["LiDAR"])),
            picture=None if raw["camera"] is None else self._picture(raw["camera"], time_s),
            imu=None if raw["IMU"] is None else _imu(raw["IMU"], time_s),
            fix=None if raw["GNSS"] is None else self._fix(raw["GNSS"], time_s),
            wheels=self._wheels(time_s),
            silent=silent,
        )

    def close(self) -> None:
        """End the sensors."""
        for sensor in self._sensors.values():
            sensor.close()
        self._sensors.clear()

    def _put(self, name: str, kind: str, mount: Mount, settings: dict[str, float]) -> None:
        import carla

        found = list(self._world.get_blueprint_library().filter(kind))
        if not found:
            raise SensorError(f"this simulator has no {kind}, which the rig's {name} needs")
        for attribute, value in settings.items():
            if not found[0].has_attribute(attribute):
                raise SensorError(
                    f"{kind} of this simulator has no attribute {attribute}: it cannot be the rig's {name}"
                )
            found[0].set_attribute(attribute, str(value))
        place = carla.Transform(
            carla.Location(mount.x_m, -mount.y_m, mount.z_m),
            carla.Rotation(yaw=-mount.yaw_deg, pitch=-mount.pitch_deg, roll=mount.roll_deg),
        )
        actor = self._world.spawn_actor(found[0], place, attach_to=self._vehicle)
        tick_s = settings.get("sensor_tick", 0.0)
        self._sensors[name] = _Sensor(actor, tick_s)

    def _points(self, raw: Any) -> Singles:
        """(n, 4) in the vehicle frame, from CARLA's left-handed frame of the sensor."""
        if int(raw.channels) != self._rig.lidar.channels:
            raise SensorError(
                f"the LiDAR has {raw.channels} channels, the rig says {self._rig.lidar.channels}: "
                "give the rig file of this LiDAR, and weights trained for it"
            )
        points: Singles = np.frombuffer(raw.raw_data, np.float32).reshape(-1, 4).copy()
        points[:, 1] *= -1.0
        turned = self._lidar_to_vehicle
        points[:, :3] = points[:, :3] @ turned[:3, :3].T + turned[:3, 3]
        return points

    def _picture(self, raw: Any, time_s: float) -> CameraFrame:
        wanted = (self._rig.camera.width_px, self._rig.camera.height_px)
        if (raw.width, raw.height) != wanted:
            raise SensorError(
                f"the camera's picture is {raw.width} x {raw.height}, the rig says {wanted[0]} x {wanted[1]}: "
                "give the rig file of this camera"
            )
        pixels = np.frombuffer(raw.raw_data, np.uint8).reshape(raw.height, raw.width, 4)
        return CameraFrame(time_s, np.ascontiguousarray(pixels[:, :, 2::-1]))

    def _wheels(self, time_s: float) -> WheelSpeed:
        """CARLA has no such sensor: as the leaderboard's speedometer this is the client's velocity, with our noise."""
        velocity, ahead = self._vehicle.get_velocity(), self._vehicle.get_transform().get_forward_vector()
        speed = velocity.x * ahead.x + velocity.y * ahead.y + velocity.z * ahead.z
        noise = self._random.normal(0.0, self._rig.wheel_speed_noise_mps)
        # A counter of teeth that stand still counts nothing.
        return WheelSpeed(time_s, speed + noise if abs(speed) > STANDS_MPS else 0.0)

    def _fix(self, raw: Any, time_s: float) -> GnssFix:
        x, y = self._geo.local(float(raw.latitude), float(raw.longitude))
        return GnssFix(time_s, x, y, float(raw.altitude))


def _imu(raw: Any, time_s: float) -> ImuSample:
    """CARLA's axes are left-handed (y right), so that turns about x and z change their sign; its compass counts
    clockwise from north, which is the local frame's y."""
    a, g = raw.accelerometer, raw.gyroscope
    compass = math.remainder(math.pi / 2.0 - float(raw.compass), math.tau)
    return ImuSample(time_s, (a.x, -a.y, a.z), (-g.x, g.y, -g.z), compass)


class _Sensor:
    """One sensor's data by frame."""

    def __init__(self, actor: Any, tick_s: float) -> None:
        self._actor = actor
        self._tick_s = tick_s
        self._came: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._held: Any | None = None
        self._last: int | None = None
        self._every = 1
        actor.listen(self._came.put)

    def is_due(self, frame: int) -> bool:
        """Should it have measured in this frame? It is due every `sensor_tick` from its first measurement on."""
        return self._last is None or frame - self._last >= self._every

    def take(self, frame: int, until: float) -> Any | None:
        """The measurement of a frame, waited for until then where it is due; None where there is none."""
        while True:
            if self._held is None:
                left = until - time.monotonic()
                try:
                    due = self.is_due(frame) and left > 0.0
                    self._held = self._came.get(timeout=left) if due else self._came.get_nowait()
                except queue.Empty:
                    return None
            if int(self._held.frame) > frame:
                return None
            found, self._held = self._held, None
            if int(found.frame) == frame or until - time.monotonic() <= 0.0:
                self._note(int(found.frame))
                return found

    def _note(self, frame: int) -> None:
        if self._tick_s > 0.0 and self._last is not None:
            self._every = max(frame - self._last, 1)
        self._last = frame

    def close(self) -> None:
        """End it; the simulator may be gone already."""
        self._actor.stop()
        self._actor.destroy()
