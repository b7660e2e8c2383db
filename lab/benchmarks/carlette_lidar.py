"""Scans per second of a 64-channel LiDAR alone on one core: 65,536 rays up to 100 m among 20 cars in the demo town.

CPU time is measured, which other programs affect less than wall time. The sensor is mounted level or tilted, and is
plain (with CARLA's default dropout) or semantic. No network is involved.
"""

from __future__ import annotations

import math
import time
from statistics import median

from carlette.blueprints import AttributeType
from carlette.errors import SpawnCollisionError
from carlette.geometry import Pose, Rotation, Vector
from carlette.opendrive.map_file import find_map, map_folders
from carlette.opendrive.road_network import RoadNetwork
from carlette.sensors import Sensor, SensorScene, SensorTick, make_sensor
from carlette.sensors.sensor_scene import ActorSurfaces
from carlette.world.actor import Actor
from carlette.world.spawn import spawn
from carlette.world.world import World

CHANNELS, COLUMNS, HERTZ = 64, 1024, 20
"""Channels, columns per turn, and turns per second of the LiDAR."""
CARS = 20
"""Number of cars."""
NEAR_M = 90.0
"""Distance from the first car within which the others are spawned (m)."""
SETTINGS = {
    "channels": CHANNELS,
    "points_per_second": CHANNELS * COLUMNS * HERTZ,
    "rotation_frequency": HERTZ,
    "range": 100,
}
"""Attributes of the LiDAR."""
PLAIN, SEMANTIC = "sensor.lidar.ray_cast", "sensor.lidar.ray_cast_semantic"
TILTED = Rotation(5.0, 20.0, -8.0)
"""Rotation of the tilted LiDAR (degrees)."""


def run(smoke: bool) -> dict[str, float]:
    """Return `scans_per_s_*` level, tilted and semantic, and the number of rays."""
    world, car = _street()
    scans = 5 if smoke else 200
    return {
        "rays": float(CHANNELS * COLUMNS),
        "scans_per_s_level": _rate(world, car, PLAIN, Rotation(), scans),
        "scans_per_s_tilted": _rate(world, car, PLAIN, TILTED, scans),
        "scans_per_s_semantic": _rate(world, car, SEMANTIC, Rotation(), scans),
    }


def _street() -> tuple[World, Actor]:
    """Return a world with cars, and the first of them, which the others surround."""
    world = World(RoadNetwork(find_map("demo_town", map_folders([]))))
    cars: list[Actor] = []
    for spot in world.roads.spawn_points():
        if cars and math.dist(world.pose(cars[0]).location, spot.location) > NEAR_M:
            continue
        try:
            cars.append(spawn(world, "vehicle.tesla.model3", {}, spot))
        except SpawnCollisionError:
            # The spawn point is occupied; the loop tries the next one.
            continue
        if len(cars) == CARS:
            break
    for _ in range(HERTZ):
        world.tick()
    return world, cars[0]


def _rate(world: World, car: Actor, type_id: str, tilt: Rotation, scans: int) -> float:
    attributes = {name: (AttributeType.STRING, str(value)) for name, value in SETTINGS.items()}
    sensor, actor = make_sensor(type_id, attributes), spawn(world, type_id, {}, Pose(Vector(z=2.4), tilt), car.id)
    world.tick()
    cast = ActorSurfaces()
    _scan(world, sensor, actor, cast)
    seconds = []
    for _ in range(scans):
        start = time.process_time()
        _scan(world, sensor, actor, cast)
        seconds.append(time.process_time() - start)
    world.remove(actor.id)
    return 1.0 / median(seconds)


def _scan(world: World, sensor: Sensor, actor: Actor, cast: ActorSurfaces) -> int:
    moment = SensorTick(SensorScene(world, cast), actor, world.pose(actor), lambda _: None)
    return sum(len(part) for body in sensor.measure(moment) for part in body)
