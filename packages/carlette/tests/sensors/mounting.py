"""Sensors without a server: mounted in a world, asked directly."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from carlette.blueprints import AttributeType
from carlette.geometry import Pose
from carlette.opendrive.map_file import MapFile
from carlette.opendrive.road_network import RoadNetwork
from carlette.sensors import Sensor, SensorScene, SensorTick, make_sensor
from carlette.sensors.sensor_scene import ActorSurfaces
from carlette.world.actor import Actor
from carlette.world.spawn import spawn
from carlette.world.world import World
from straight import straight_road

ON_ROOF_M = 2.4


@lru_cache
def network(slope: float = 0.0) -> RoadNetwork:
    """The straight road; its static scene is built once for all tests."""
    return RoadNetwork(MapFile("straight", straight_road(slope)))


def street(slope: float = 0.0) -> World:
    """A new world on the straight road."""
    return World(network(slope))


@dataclass
class Mounted:
    """A sensor and its actor."""

    world: World
    sensor: Sensor
    actor: Actor
    cast: ActorSurfaces

    @property
    def moment(self) -> SensorTick:
        pose = self.world.pose(self.actor)
        return SensorTick(SensorScene(self.world, self.cast), self.actor, pose, lambda item: [item.id, item.type_id])

    def bodies(self) -> list[bytes]:
        """The messages of this tick, each in one piece."""
        return [b"".join(map(bytes, item)) for item in self.sensor.measure(self.moment)]

    def body(self) -> bytes:
        (only,) = self.bodies()
        return only


def mount(world: World, type_id: str, pose: Pose | None = None, parent: int = 0, **attributes: Any) -> Mounted:
    """A sensor with some attributes of its own."""
    typed = {name: (AttributeType.STRING, str(value)) for name, value in attributes.items()}
    sensor = make_sensor(type_id, typed)
    return Mounted(world, sensor, spawn(world, type_id, typed, pose or Pose(), parent), ActorSurfaces())


def lidar_points(body: bytes, width: int = 4) -> tuple[float, np.ndarray, np.ndarray]:
    """The head's angle (rad), the points of each channel, and the rows."""
    angle, channels = struct.unpack_from("<fI", body)
    counts = np.frombuffer(body, "<u4", channels, 8)
    return angle, counts, np.frombuffer(body, "<f4", offset=8 + 4 * channels).reshape(-1, width)
