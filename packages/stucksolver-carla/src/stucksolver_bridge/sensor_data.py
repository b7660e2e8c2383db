"""Facts for the solver's process from a vehicle that uses its own sensors: measurements, and nobody's true position.

The map with its lights and signs is known beforehand, like a high-definition map. The vehicle also knows its own size,
its lamps and the speed limit. Everything else comes from the sensors. Python 3.7, standard library only.
"""

from __future__ import annotations

import math
from typing import Any, Mapping, Sequence

from stucksolver_bridge.shared_memory import SharedFrames
from stucksolver_bridge.world_data import place, route_places, sign_places

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
"""The sensors that are used, by the leaderboard's names for their types. A camera may also be `REAR`."""
BACK_DEG = 90.0
"""A camera that is turned farther to the side looks to the rear."""
LARGEST_PICTURE_BYTES = 4096 * 4096 * 4
LARGEST_SWEEP_BYTES = 16 * 1024 * 1024
"""A million points; a whole turn of the leaderboard's LiDAR has 60,000. Unwritten parts take no memory."""
ALL = "sensors"
"""The name under which the solver's process asks for the newest measurements."""
NO_PICTURE = "sensors_without_picture"
"""The same without the cameras' pictures."""


class SensorData:
    """Facts about one vehicle. `sensors`: the agent's sensors, as it declares them to the leaderboard."""

    def __init__(self, vehicle: Any, carla_map: Any, sensors: Sequence[Mapping[str, Any]]) -> None:
        self._vehicle = vehicle
        self._world = vehicle.get_world()
        self._map = carla_map
        self._sensors = [dict(sensor) for sensor in sensors]
        self._ids = {name: str(sensor["id"]) for sensor in sensors for name in (name_of(sensor),) if name is not None}
        self._data: Mapping[str, Any] = {}
        sizes = {CAMERA: LARGEST_PICTURE_BYTES, LIDAR: LARGEST_SWEEP_BYTES, REAR: LARGEST_PICTURE_BYTES}
        self.frames = SharedFrames(sizes)

    def opening(self, route: Sequence[Any]) -> dict[str, Any]:
        """Return what is sent once at the start: map, the vehicle's size and wheels, lights, stop signs, route."""
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
        """Return what is sent on every tick: the time, the speed limit, the vehicle's own lamps."""
        stamp = self._world.get_snapshot()
        return {
            "time": stamp.timestamp.elapsed_seconds,
            "delta": stamp.timestamp.delta_seconds,
            "frame": stamp.frame,
            "limit": self._vehicle.get_speed_limit(),
            "lamps": int(self._vehicle.get_light_state()),
        }

    def take_in(self, input_data: Mapping[str, Any]) -> None:
        """Take this tick's data, as the leaderboard passes them to agents: (frame, data) by the sensor's id.

        Data are copied only when they are requested, and otherwise dropped.
        """
        self._data = input_data

    def give(self, what: str) -> Any:
        """Return the newest measurements and the tick to which they belong; None if the name is unknown here."""
        if what not in (ALL, NO_PICTURE):
            return None
        picture, rear = (None if what == NO_PICTURE else self._of(camera) for camera in (CAMERA, REAR))
        sweep = self._of(LIDAR)
        speed = self._of(SPEED)
        return {
            "tick": self.tick(),
            CAMERA: None if picture is None else self.frames.put(CAMERA, picture),
            REAR: None if rear is None else self.frames.put(REAR, rear),
            LIDAR: None if sweep is None else self.frames.put(LIDAR, sweep),
            IMU: numbers(self._of(IMU)),
            GNSS: numbers(self._of(GNSS)),
            SPEED: numbers([speed["speed"]] if isinstance(speed, Mapping) and "speed" in speed else None),
        }

    def close(self) -> None:
        """Free the shared memory."""
        self.frames.close()

    def _of(self, sensor: str) -> Any:
        """Return the data of one of the sensors; None if it gave none."""
        given = self._data.get(self._ids.get(sensor, ""))
        return given[1] if isinstance(given, (tuple, list)) and len(given) == 2 else None


def name_of(sensor: Mapping[str, Any]) -> str | None:
    """Return our name for a sensor that an agent declares to the leaderboard; None if it is not used."""
    name = TYPES.get(str(sensor.get("type")))
    if name != CAMERA:
        return name
    return REAR if math.cos(math.radians(float(sensor.get("yaw", 0.0)))) < math.cos(math.radians(BACK_DEG)) else CAMERA


def numbers(values: Any) -> list[float] | None:
    """Return finite numbers as a list; None if there are none, or if one of them is not finite."""
    if values is None:
        return None
    found = [float(value) for value in values]
    return found if found and all(math.isfinite(value) for value in found) else None


def _light(light: Any) -> dict[str, Any]:
    """Return a light's id, stop lines, heads and trigger box."""
    volume, stands = light.trigger_volume, light.get_transform()
    heads = [[*_point(box.location), *_point(box.extent), box.rotation.yaw] for box in light.get_light_boxes()]
    return {
        "id": light.id,
        "stops": [place(waypoint) for waypoint in light.get_stop_waypoints()],
        "heads": heads,
        "at": [*_point(stands.location), stands.rotation.pitch, stands.rotation.yaw, stands.rotation.roll],
        "volume": [*_point(volume.location), *_point(volume.extent)],
    }


def _point(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]
