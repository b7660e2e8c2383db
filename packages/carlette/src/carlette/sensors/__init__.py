"""Sensors: the measurements of their actors on each tick. A new one is a new file and a line in `ALL`."""

from carlette.errors import RequestError
from carlette.sensors.camera import ColorCamera, DepthCamera, InstanceCamera, SemanticCamera
from carlette.sensors.collision import CollisionSensor
from carlette.sensors.gnss import GnssSensor
from carlette.sensors.imu import ImuSensor
from carlette.sensors.lidar import LidarSensor, SemanticLidarSensor
from carlette.sensors.obstacle import ObstacleSensor
from carlette.sensors.radar import RadarSensor
from carlette.sensors.sensor import Body, LateSensor, Sensor, SensorAttributes, SensorTick
from carlette.sensors.sensor_scene import SensorScene
from carlette.world.actor import Attributes

__all__ = ["ALL", "Body", "LateSensor", "Sensor", "SensorAttributes", "SensorScene", "SensorTick", "make_sensor"]

ALL: dict[str, type[Sensor]] = {
    "sensor.camera.depth": DepthCamera,
    "sensor.camera.instance_segmentation": InstanceCamera,
    "sensor.camera.rgb": ColorCamera,
    "sensor.camera.semantic_segmentation": SemanticCamera,
    "sensor.lidar.ray_cast": LidarSensor,
    "sensor.lidar.ray_cast_semantic": SemanticLidarSensor,
    "sensor.other.collision": CollisionSensor,
    "sensor.other.gnss": GnssSensor,
    "sensor.other.imu": ImuSensor,
    "sensor.other.obstacle": ObstacleSensor,
    "sensor.other.radar": RadarSensor,
}
"""Classes by blueprint id."""


def make_sensor(type_id: str, attributes: Attributes) -> Sensor:
    """Return the sensor of an actor; raise `RequestError` for an unsupported kind or attribute."""
    kind = ALL.get(type_id)
    if kind is None:
        raise RequestError(
            f"Spawn of '{type_id}' refused: this server does not simulate that sensor; it has {', '.join(ALL)}"
        )
    return kind(SensorAttributes(type_id, attributes))
