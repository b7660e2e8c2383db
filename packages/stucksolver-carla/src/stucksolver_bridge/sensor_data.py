"""Collects the data of a vehicle with sensor-based perception for the solver's process, without any true positions.

The map with its lights and signs is available beforehand, like a high-definition map. The vehicle also sends its size,
its lamps and the speed limit. Everything else comes from the sensors. Python 3.7, standard library only.
"""

from __future__ import annotations

import math
from typing import Any, Mapping, Sequence

from stucksolver_bridge.shared_memory import SharedFrames
from stucksolver_bridge.world_data import route_places, sign_places, waypoint_numbers

CAMERA = "camera"
REAR = "rear camera"
LIDAR = "lidar"
IMU = "imu"
GNSS = "gnss"
SPEED = "speed"
TYPES = {
    "sensor.camera.rgb": CAMERA,
    "sensor.lidar.ray_cast": LIDAR,
    "sensor.other.imu": IMU,
    "sensor.other.gnss": GNSS,
    "sensor.speedometer": SPEED,
}
"""Names of the sensors that are used, by the leaderboard's names for their types. A camera may also be `REAR`."""
REAR_FROM_DEG = 90.0
"""Yaw beyond which a camera counts as the rear camera (degrees)."""
MAX_PICTURE_BYTES = 4096 * 4096 * 4
"""Memory for one picture: 4096 x 4096 pixels of four bytes. Ours."""
MAX_SWEEP_BYTES = 16 * 1024 * 1024
"""Memory for one sweep: a million points. A whole turn of the leaderboard's LiDAR has 60,000. Unwritten parts take no
memory. Ours."""
ALL = "sensors"
"""The name under which the solver's process requests the newest measurements."""
NO_PICTURE = "sensors_without_picture"
"""The name under which it requests the newest measurements without the cameras' pictures."""


class SensorData:
    """Data of one vehicle. `sensors`: the agent's sensors, as it declares them to the leaderboard."""

    def __init__(self, vehicle: Any, carla_map: Any, sensors: Sequence[Mapping[str, Any]]) -> None:
        self._vehicle = vehicle
        self._world = vehicle.get_world()
        self._map = carla_map
        self._sensors = [dict(sensor) for sensor in sensors]
        self._ids = {name: str(sensor["id"]) for sensor in sensors for name in (name_of(sensor),) if name is not None}
        self._data: Mapping[str, Any] = {}
        sizes = {CAMERA: MAX_PICTURE_BYTES, LIDAR: MAX_SWEEP_BYTES, REAR: MAX_PICTURE_BYTES}
        self.frames = SharedFrames(sizes)

    def opening(self, route: Sequence[Any]) -> dict[str, Any]:
        """Return the data for the start: map, the vehicle's size and wheels, lights, stop signs, route."""
        box = self._vehicle.bounding_box
        actors = self._world.get_actors()
        wheels = self._vehicle.get_physics_control().wheels
        return {
            "map": self._map.name.rsplit("/", 1)[-1],
            "xodr": self._map.to_opendrive(),
            "id": self._vehicle.id,
            "box": [*_point(box.location), *_point(box.extent)],
            "wheels": [[*_point(wheel.position), wheel.max_steer_angle] for wheel in wheels],
            "lights": [_light(light) for light in actors.filter("*traffic_light*")],
            "stop_signs": [sign_places(sign) for sign in actors.filter("*traffic.stop*")],
            "route": route_places(route),
            "height": float(route[0].waypoint.transform.location.z),
            "sensors": self._sensors,
            "frames": {"fd": self.frames.fd, "size": self.frames.size},
            "tick": self.tick(),
        }

    def tick(self) -> dict[str, Any]:
        """Return the data for every tick: the time, the speed limit, the vehicle's lamps."""
        stamp = self._world.get_snapshot()
        return {
            "time": stamp.timestamp.elapsed_seconds,
            "delta": stamp.timestamp.delta_seconds,
            "frame": stamp.frame,
            "limit": self._vehicle.get_speed_limit(),
            "lamps": int(self._vehicle.get_light_state()),
        }

    def take_in(self, input_data: Mapping[str, Any]) -> None:
        """Store this tick's data, as the leaderboard passes them to agents: (frame, data) by the sensor's id.

        Data are copied only on request. The next call replaces them.
        """
        self._data = input_data

    def give(self, what: str) -> Any:
        """Return the newest measurements and their tick; None if the name is not one of this module's requests."""
        if what not in (ALL, NO_PICTURE):
            return None
        picture, rear = (None if what == NO_PICTURE else self._data_of(camera) for camera in (CAMERA, REAR))
        sweep = self._data_of(LIDAR)
        speed = self._data_of(SPEED)
        return {
            "tick": self.tick(),
            CAMERA: None if picture is None else self.frames.put(CAMERA, picture),
            REAR: None if rear is None else self.frames.put(REAR, rear),
            LIDAR: None if sweep is None else self.frames.put(LIDAR, sweep),
            IMU: numbers(self._data_of(IMU)),
            GNSS: numbers(self._data_of(GNSS)),
            SPEED: numbers([speed["speed"]] if isinstance(speed, Mapping) and "speed" in speed else None),
        }

    def close(self) -> None:
        """Free the shared memory."""
        self.frames.close()

    def _data_of(self, sensor: str) -> Any:
        """Return the data of one of the sensors; None without data."""
        entry = self._data.get(self._ids.get(sensor, ""))
        return entry[1] if isinstance(entry, (tuple, list)) and len(entry) == 2 else None


def name_of(sensor: Mapping[str, Any]) -> str | None:
    """Return this module's name for a sensor that an agent declares to the leaderboard; None if it is not used."""
    name = TYPES.get(str(sensor.get("type")))
    if name != CAMERA:
        return name
    return (
        REAR
        if math.cos(math.radians(float(sensor.get("yaw", 0.0)))) < math.cos(math.radians(REAR_FROM_DEG))
        else CAMERA
    )


def numbers(values: Any) -> list[float] | None:
    """Return finite numbers as a list; None without any, or if one of them is not finite."""
    if values is None:
        return None
    finite = [float(value) for value in values]
    return finite if finite and all(math.isfinite(value) for value in finite) else None


def _light(light: Any) -> dict[str, Any]:
    """Return a light's id, stop lines, heads and trigger box."""
    volume, pose = light.trigger_volume, light.get_transform()
    heads = [[*_point(box.location), *_point(box.extent), box.rotation.yaw] for box in light.get_light_boxes()]
    return {
        "id": light.id,
        "stops": [waypoint_numbers(waypoint) for waypoint in light.get_stop_waypoints()],
        "heads": heads,
        "at": [*_point(pose.location), pose.rotation.pitch, pose.rotation.yaw, pose.rotation.roll],
        "volume": [*_point(volume.location), *_point(volume.extent)],
    }


def _point(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]
