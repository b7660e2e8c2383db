"""Runs an agent written for the CARLA leaderboard (a subclass of `AutonomousAgent`) without the leaderboard.

The agent gets the input that the leaderboard documents: its sensors' data by id, a route in world and GNSS coordinates,
and the time since the start.
"""

from __future__ import annotations

import contextlib
import enum
import importlib
import math
import sys
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import carla
import numpy as np

from stucksolver_carla.drivers.behavior import RoutePoint
from stucksolver_eval.drivers.agent import AgentError

PICTURES_LIMIT_S = 60.0
"""Wall time limit for the data of all sensors of a tick (s). The first images of a town take longest. Ours."""
PLACE = ("x", "y", "z", "roll", "pitch", "yaw")
NAMES = {"width": "image_size_x", "height": "image_size_y"}
"""Fields of a sensor's description that have another name in the blueprint."""
FIXED_ATTRIBUTES: dict[str, dict[str, float]] = {
    "sensor.lidar.ray_cast": {
        "channels": 64,
        "range": 85.0,
        "rotation_frequency": 10.0,
        "points_per_second": 600_000,
        "upper_fov": 10.0,
        "lower_fov": -30.0,
        "atmosphere_attenuation_rate": 0.004,
        "dropoff_general_rate": 0.45,
        "dropoff_intensity_limit": 0.8,
        "dropoff_zero_intensity": 0.4,
    },
    "sensor.other.imu": {f"noise_{kind}_stddev_{axis}": 0.001 for kind in ("accel", "gyro") for axis in "xyz"},
    "sensor.other.gnss": {f"noise_{axis}_stddev": 0.000005 for axis in ("lat", "lon", "alt")},
}
"""Attributes by sensor type that the CARLA leaderboard fixes. Agents cannot change them."""
SPEED, TOWN = "sensor.speedometer", "sensor.opendrive_map"
"""Pseudo-sensors of the leaderboard that the simulator does not have."""


class RoadOption(enum.IntEnum):
    """The enumeration of CARLA's `agents` package, used if that is not installed."""

    VOID = -1
    LEFT = 1
    RIGHT = 2
    STRAIGHT = 3
    LANEFOLLOW = 4
    CHANGELANELEFT = 5
    CHANGELANERIGHT = 6


OPTIONS = {
    "left": "LEFT",
    "right": "RIGHT",
    "straight": "STRAIGHT",
    "lane_follow": "LANEFOLLOW",
    "change_left": "CHANGELANELEFT",
    "change_right": "CHANGELANERIGHT",
}


def is_leaderboard_agent(made: Any) -> bool:
    """Return True if a class has the methods of a leaderboard agent."""
    return all(hasattr(made, part) for part in ("setup", "sensors", "run_step", "set_global_plan"))


class LeaderboardAgent:
    """Implements `Agent`. `config` is the path that the agent's `setup` gets."""

    def __init__(self, made: Any, config: str, client: carla.Client, hero: carla.Vehicle, carla_map: carla.Map) -> None:
        self._hero, self._map = hero, carla_map
        self._world = hero.get_world()
        self._name = f"{made.__module__}:{made.__name__}"
        self._began_s = float(self._world.get_snapshot().timestamp.elapsed_seconds)
        _introduce(client, self._world, hero)
        self._agent = made("localhost", 0)
        self._agent.setup(config)
        self._since: int | None = None
        """The frame in which the sensors were spawned; they have data from the next frame on."""
        self._sensors: dict[str, _LeaderboardSensor] = {}

    def set_route(self, route: Sequence[RoutePoint]) -> None:
        """Pass the route to the agent, and spawn its sensors the first time. Raises `AgentError`."""
        option = _road_option()
        places = [(p.waypoint.transform, option[OPTIONS.get(p.command, "LANEFOLLOW")]) for p in route]
        gps = []
        for transform, turn in places:
            at = self._map.transform_to_geolocation(transform.location)
            gps.append(({"lat": at.latitude, "lon": at.longitude, "z": at.altitude}, turn))
        self._agent.set_global_plan(gps, places)
        if self._since is None:
            self._since = int(self._world.get_snapshot().frame)
            for spec in self._agent.sensors():
                self._sensors[str(spec["id"])] = self._put(spec)

    def run_step(self) -> Any:
        """Wait for this tick's sensor data and return the agent's control. Raises `AgentError`."""
        snapshot = self._world.get_snapshot()
        _tell_time(snapshot)
        frame, now_s = int(snapshot.frame), float(snapshot.timestamp.elapsed_seconds)
        if self._since is None or frame <= self._since:
            return carla.VehicleControl(brake=1.0)
        until_s = time.monotonic() + PICTURES_LIMIT_S
        data = {name: (frame, sensor.read(frame, until_s)) for name, sensor in self._sensors.items()}
        return self._agent.run_step(data, now_s - self._began_s)

    def close(self) -> None:
        """Destroy the agent, then its sensors."""
        try:
            destroy = getattr(self._agent, "destroy", None)
            if destroy is not None:
                destroy()
        finally:
            for sensor in self._sensors.values():
                sensor.close()
            self._sensors.clear()

    def _put(self, spec: dict[str, Any]) -> _LeaderboardSensor:
        kind = str(spec["type"])
        if kind == SPEED:
            return _Speedometer(self._hero)
        if kind == TOWN:
            return _TownMap(self._map)
        library = self._world.get_blueprint_library()
        found = list(library.filter(kind))
        if not found:
            raise AgentError(f"{self._name} requires a sensor {kind!r}, which this simulator does not have")
        blueprint = found[0]
        for name, fixed_value in FIXED_ATTRIBUTES.get(kind, {}).items():
            blueprint.set_attribute(name, str(fixed_value))
        for name, value in spec.items():
            attribute = NAMES.get(name, name)
            if name not in (*PLACE, "type", "id", "sensor_tick") and blueprint.has_attribute(attribute):
                blueprint.set_attribute(attribute, str(value))
        x, y, z, roll, pitch, yaw = (float(spec.get(part, 0.0)) for part in PLACE)
        place = carla.Transform(carla.Location(x, y, z), carla.Rotation(pitch=pitch, roll=roll, yaw=yaw))
        return _Listening(self._world.spawn_actor(blueprint, place, attach_to=self._hero), self._name)


class _LeaderboardSensor(ABC):
    """Data of one sensor in the leaderboard's form."""

    @abstractmethod
    def read(self, frame: int, until_s: float) -> Any:
        """Return the data of a frame. Waits until `until_s` on the monotonic clock. Raises `AgentError`."""

    def close(self) -> None:  # noqa: B027 (most need nothing here)
        """Release the sensor."""


class _Speedometer(_LeaderboardSensor):
    def __init__(self, hero: carla.Vehicle) -> None:
        self._hero = hero

    def read(self, frame: int, until_s: float) -> Any:
        velocity, ahead = self._hero.get_velocity(), self._hero.get_transform().get_forward_vector()
        return {"speed": velocity.x * ahead.x + velocity.y * ahead.y + velocity.z * ahead.z}


class _TownMap(_LeaderboardSensor):
    def __init__(self, carla_map: carla.Map) -> None:
        self._text = carla_map.to_opendrive()

    def read(self, frame: int, until_s: float) -> Any:
        return {"opendrive": self._text}


class _Listening(_LeaderboardSensor):
    """A sensor of the simulator.

    It stores only its latest data, because the agent does not read it while a plan runs.
    """

    def __init__(self, actor: carla.Sensor, agent_name: str) -> None:
        self._actor, self._agent_name = actor, agent_name
        self._latest: Any | None = None
        self._came = threading.Condition()
        actor.listen(self._take)

    def _take(self, data: Any) -> None:
        with self._came:
            self._latest = data
            self._came.notify_all()

    def read(self, frame: int, until_s: float) -> Any:
        with self._came:
            if self._came.wait_for(lambda: self._is_of(frame), max(until_s - time.monotonic(), 0.0)):
                return _as_array(self._latest)
        kind = self._actor.type_id
        raise AgentError(
            f"{kind}, which {self._agent_name} requires, sent no data for frame {frame} within {PICTURES_LIMIT_S:.0f} s"
        )

    def _is_of(self, frame: int) -> bool:
        return self._latest is not None and self._latest.frame >= frame

    def close(self) -> None:
        # The server may already have ended, and then the sensor is gone too.
        with contextlib.suppress(RuntimeError):
            self._actor.stop()
            self._actor.destroy()


def _as_array(data: Any) -> Any:
    """Return data as arrays: images (rows, columns, 4) in BGRA, LiDAR and radar (n, 4), GNSS (3,), IMU (7,).

    GNSS is latitude, longitude (degrees) and altitude (m). IMU is acceleration (m/s²), rotation rate (rad/s) and
    compass (rad). LiDAR is x, y, z (m) and intensity in the sensor's frame. Radar is depth (m), azimuth, altitude (rad)
    and velocity (m/s).
    """
    if isinstance(data, carla.Image):
        return np.frombuffer(data.raw_data, dtype=np.uint8).reshape(data.height, data.width, 4).copy()
    if isinstance(data, carla.LidarMeasurement):
        return np.frombuffer(data.raw_data, dtype=np.float32).reshape(-1, 4).copy()
    if isinstance(data, carla.RadarMeasurement):
        # CARLA's order is velocity, altitude, azimuth, depth. Agents get the reverse.
        return np.frombuffer(data.raw_data, dtype=np.float32).reshape(-1, 4)[:, ::-1].copy()
    if isinstance(data, carla.GnssMeasurement):
        return np.array([data.latitude, data.longitude, data.altitude])
    if isinstance(data, carla.IMUMeasurement):
        a, g = data.accelerometer, data.gyroscope
        compass = 0.0 if math.isnan(data.compass) else data.compass
        return np.array([a.x, a.y, a.z, g.x, g.y, g.z, compass])
    return data


def _road_option() -> Any:
    local_planner = sys.modules.get("agents.navigation.local_planner")
    return RoadOption if local_planner is None else local_planner.RoadOption


def _data_provider() -> Any | None:
    """Return scenario_runner's `CarlaDataProvider`, or None if the agent has not imported scenario_runner."""
    if "srunner" not in sys.modules:
        return None
    return importlib.import_module("srunner.scenariomanager.carla_data_provider").CarlaDataProvider


def _introduce(client: carla.Client, world: carla.World, hero: carla.Vehicle) -> None:
    """Register client, world and hero with scenario_runner, where Bench2Drive's base class looks for them."""
    provider = _data_provider()
    if provider is None:
        return
    provider.set_client(client)
    provider.set_world(world)
    provider.register_actor(hero, hero.get_transform())
    provider._carla_actor_pool[hero.id] = hero


def _tell_time(snapshot: carla.WorldSnapshot) -> None:
    provider = _data_provider()
    if provider is None:
        return
    provider.on_carla_tick()
    timer = sys.modules.get("srunner.scenariomanager.timer")
    if timer is not None:
        timer.GameTime.on_carla_tick(snapshot.timestamp)
