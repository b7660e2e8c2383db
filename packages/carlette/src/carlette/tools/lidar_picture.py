"""A picture of a LiDAR scan, for the documents: `python -m carlette.tools.lidar_picture docs/images/lidar.png`.

The left side shows the scan from above and behind the car, the right side from straight above. Colors are
semantic tags.
"""

from __future__ import annotations

import argparse
import struct
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from carlette.blueprints import AttributeType
from carlette.camera.rendering import tags
from carlette.geometry import Floats, Pose, Rotation, Vector
from carlette.opendrive.map_file import find_map, map_folders
from carlette.opendrive.road_network import RoadNetwork
from carlette.sensors import SensorScene, SensorTick, make_sensor
from carlette.sensors.rotations import axes
from carlette.world.spawn import spawn
from carlette.world.world import World

HEIGHT, WIDTH = 640, 860
"""Size of the picture (px)."""
COLORS = {
    tags.ROAD: (120, 110, 140),
    tags.SIDEWALK: (230, 60, 220),
    tags.BUILDING: (225, 165, 90),
    tags.POLE: (190, 190, 190),
    tags.TRAFFIC_LIGHT: (250, 220, 40),
    tags.TRAFFIC_SIGN: (250, 250, 80),
    tags.VEGETATION: (90, 190, 60),
    tags.TERRAIN: (70, 110, 60),
    tags.PEDESTRIAN: (255, 50, 70),
    tags.RIDER: (255, 90, 90),
    tags.CAR: (60, 140, 255),
    tags.BUS: (60, 220, 235),
    tags.BICYCLE: (170, 120, 255),
    tags.DYNAMIC: (255, 150, 40),
}
"""Colors (red, green, blue) by tag."""
SETTINGS = {
    "channels": 64,
    "points_per_second": 64 * 1800 * 20,
    "rotation_frequency": 20,
    "range": 70,
    "lower_fov": -25,
}
"""Attributes of the LiDAR."""
PROPS = (
    ("vehicle.mitsubishi.fusorosa", 17.0, -3.5, 180.0),
    ("vehicle.tesla.model3", 13.0, 0.0, 0.0),
    ("vehicle.bh.crossbike", 6.0, 2.6, 0.0),
    ("walker.pedestrian.0005", 8.5, 4.6, 90.0),
    ("static.prop.constructioncone", 7.0, -1.3, 0.0),
    ("static.prop.constructioncone", 9.0, -1.5, 0.0),
)
"""Objects ahead of the car: type, meters ahead and to the right, and heading (degrees)."""


def main() -> None:
    """Draw a scan into the file named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path, help="the PNG file to write")
    parser.add_argument("--spawn-point", type=int, default=3, help="where in the demo town (default: 3)")
    options = parser.parse_args()
    options.file.write_bytes(png(picture(options.spawn_point)))


def picture(number: int) -> NDArray[np.uint8]:
    """Return both views side by side, (height, width, 3)."""
    points, colors = scan(number)
    behind = axes(Rotation(pitch=-22.0))
    local = (points - np.array([-13.0, 0.0, 7.0])) @ behind
    near = local[:, 0] > 1.0
    flat = 520.0 * local[near, 1:] / local[near, :1]
    left = draw_dots(WIDTH / 2 + flat[:, 0], HEIGHT * 0.42 - flat[:, 1], colors[near], -local[near, 0], WIDTH)
    right = draw_dots(HEIGHT / 2 + 9.0 * points[:, 1], HEIGHT / 2 - 9.0 * points[:, 0], colors, points[:, 2], HEIGHT)
    return np.concatenate([left, np.full((HEIGHT, 6, 3), 255, np.uint8), right], axis=1)


def scan(number: int) -> tuple[Floats, NDArray[np.uint8]]:
    """Return points (n, 3) in the sensor's frame and their colors (n, 3)."""
    world = World(RoadNetwork(find_map("demo_town", map_folders([]))))
    spot = world.roads.spawn_points()[number]
    car = spawn(world, "vehicle.lincoln.mkz_2020", {}, spot)
    for type_id, ahead, aside, yaw in PROPS:
        spawn(world, type_id, {}, spot.compose(Pose(Vector(ahead, aside, 0.6), Rotation(yaw=yaw))))
    world.doors.move(car.row, car.box, 0, True)
    attributes = {name: (AttributeType.STRING, str(value)) for name, value in SETTINGS.items()}
    type_id = "sensor.lidar.ray_cast_semantic"
    sensor, actor = make_sensor(type_id, attributes), spawn(world, type_id, {}, Pose(Vector(z=2.3)), car.id)
    for _ in range(40):
        world.tick()
    moment = SensorTick(SensorScene(world), actor, world.pose(actor), lambda _: None)
    (body,) = (parts[1] for parts in sensor.measure(moment))
    rows = np.frombuffer(body, np.float32).reshape(-1, 6)
    table = np.full((256, 3), 140, np.uint8)
    for tag, color in COLORS.items():
        table[tag] = color
    return rows[:, :3].astype(float), table[rows.view(np.uint32)[:, 5]]


def draw_dots(x: Floats, y: Floats, colors: NDArray[np.uint8], order: Floats, width: int) -> NDArray[np.uint8]:
    """Return dots of two by two pixels, those with the highest `order` on top."""
    image = np.full((HEIGHT, width, 3), 18, np.uint8)
    ranked = np.argsort(order)
    for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
        column, row = x[ranked].astype(int) + dx, y[ranked].astype(int) + dy
        inside = (column >= 0) & (column < width) & (row >= 0) & (row < HEIGHT)
        image[row[inside], column[inside]] = colors[ranked][inside]
    return image


def png(image: NDArray[np.uint8]) -> bytes:
    """Return an RGB picture as PNG."""
    height, width, _ = image.shape
    lines = b"".join(b"\0" + row.tobytes() for row in image)
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", head) + _chunk(b"IDAT", zlib.compress(lines, 9)) + _chunk(b"IEND", b"")
    )


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


if __name__ == "__main__":
    main()
