"""Pictures of everything that must be recognizable.

```
python -m carlette.tools.gallery --out DIR                 draws all of them
python -m carlette.tools.gallery --out DIR --only night    draws those named
```

It requires the package pillow. The pictures are those of `docs/carlette-camera.md`.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from carlette.blueprints import load_catalog
from carlette.camera.arrays import Bytes
from carlette.camera.models.signs import post_sign
from carlette.camera.rendering import tags
from carlette.camera.rendering.lighting import (
    CLOUDINESS,
    DEPOSITS,
    FOG_DENSITY,
    PRECIPITATION,
    SUN_ALTITUDE,
    SUN_AZIMUTH,
    WETNESS,
)
from carlette.camera.rendering.renderer import RenderPart
from carlette.camera.rendering.scene_capture import take, the_renderer
from carlette.camera.rendering.view import CameraView, matrix_of
from carlette.geometry import Pose, Rotation, Vector
from carlette.maps import DEMO_TOWN
from carlette.opendrive.map_file import load_map
from carlette.opendrive.road_network import RoadNetwork
from carlette.physics.doors import ALL, STOP_ARM
from carlette.world.actor import Actor, ActorKind
from carlette.world.settings import CLEAR_NOON
from carlette.world.spawn import spawn
from carlette.world.traffic_lights import Color
from carlette.world.world import World

WIDTH = 800
"""Width of a picture (px)."""
HEIGHT = 450
"""Height of a picture (px)."""
FOV_DEG = 90.0
"""Field of view (degrees)."""
QUALITY = 82
"""Quality of the JPEG files (0 to 100). Ours."""
SPOT = 20
"""Index of the spawn point from which most pictures are taken. Ours."""
BRAKE, RIGHT, LEFT, REVERSE, LOW, FLASH = 8, 16, 32, 64, 2, 512
"""Flags of `carla.VehicleLightState`; `FLASH` is `Special1`."""


class Studio:
    """A world in which objects are put ahead and to the right of one spot on a road."""

    def __init__(self, network: RoadNetwork) -> None:
        self.world = World(network)
        self.spot = network.spawn_points()[SPOT]
        self.extra: list[RenderPart] = []

    def pose_at(self, ahead_m: float, right_m: float, up_m: float = 0.0, turn_deg: float = 0.0) -> Pose:
        """Return a pose relative to the spot."""
        (x, y, _), yaw = self.spot.location, math.radians(self.spot.rotation.yaw)
        east = x + ahead_m * math.cos(yaw) - right_m * math.sin(yaw)
        south = y + ahead_m * math.sin(yaw) + right_m * math.cos(yaw)
        return Pose(Vector(east, south, up_m), Rotation(0.0, self.spot.rotation.yaw + turn_deg, 0.0))

    def add_actor(
        self, type_id: str, ahead_m: float, right_m: float, turn_deg: float = 0.0, *, lights: int = 0, **attributes: str
    ) -> Actor:
        """Spawn an actor with `attributes` such as `color`."""
        definition = load_catalog().definitions[type_id]
        values = {
            attribute.id: (attribute.type, attributes.get(attribute.id, attribute.value))
            for attribute in definition.attributes
        }
        half_m = 0.0
        if type_id in load_catalog().walkers:
            half_m = load_catalog().walkers[type_id].box.extent.z
        actor = spawn(self.world, type_id, values, self.pose_at(ahead_m, right_m, half_m, turn_deg))
        if lights:
            self.world.fleet.light_state[actor.index] = lights
        return actor

    def walk(self, actor: Actor, speed_mps: float) -> None:
        """Make a walker go in the direction that it faces."""
        yaw = math.radians(self.world.pose(actor).rotation.yaw)
        self.world.walkers.control[actor.index] = (math.cos(yaw), math.sin(yaw), 0.0, speed_mps, 0.0)

    def weather(self, **values: float) -> None:
        """Set some of the weather's numbers by name."""
        numbers = list(CLEAR_NOON)
        for name, value in values.items():
            numbers[_WEATHER[name]] = value
        self.world.weather = tuple(numbers)

    def view(
        self, ahead_m: float = 0.0, right_m: float = 0.0, up_m: float = 1.7, pitch_deg: float = -4.0,
        turn_deg: float = 0.0, ticks: int = 20,
    ) -> CameraView:  # fmt: skip
        """Wait `ticks` ticks and return a view along the road."""
        for _ in range(ticks):
            self.world.tick()
        pose = self.pose_at(ahead_m, right_m, up_m, turn_deg)
        return CameraView(replace_pitch(pose, pitch_deg), WIDTH, HEIGHT, FOV_DEG)

    def shoot(self, view: CameraView, kind: str = "rgb") -> Bytes:
        """Return the picture as (height, width, 3) red, green, blue."""
        shot = take(self.world)
        shot = replace(shot, parts=[*shot.parts, *self.extra])
        renderer = the_renderer()
        if kind == "depth":
            near = np.clip(1.0 - np.log(np.maximum(renderer.depth(shot, view), 1.0)) / math.log(300.0), 0.0, 1.0)
            return np.repeat((255 * near).astype(np.uint8)[..., None], 3, axis=2)
        if kind == "semantic":
            return PALETTE[renderer.tags(shot, view)[..., 2]]
        if kind == "instance":
            instances = renderer.instances(shot, view).astype(np.uint32)
            return np.stack(
                [instances[..., 2] * 9 % 256, instances[..., 1] * 71 % 256, instances[..., 1] * 151 % 256], axis=2
            ).astype(np.uint8)
        return renderer.rgb(shot, view)[..., 2::-1]


def replace_pitch(pose: Pose, pitch_deg: float) -> Pose:
    """Return the same pose with another pitch."""
    return Pose(pose.location, Rotation(pitch_deg, pose.rotation.yaw, 0.0))


def _street(studio: Studio) -> CameraView:
    """Return the scene of the weather pictures: traffic, a pedestrian, a cyclist, a truck."""
    studio.add_actor("vehicle.lincoln.mkz_2020", 11.0, 0.0, lights=BRAKE | LOW, color="180,44,44")
    studio.add_actor("vehicle.tesla.model3", 12.0, -7.0, 180.0, lights=LOW, color="22,62,120")
    studio.add_actor("vehicle.mercedes.sprinter", 26.0, -3.5, lights=LOW, color="255,255,255")
    studio.add_actor("vehicle.carlamotors.european_hgv", 34.0, 0.2, lights=LOW, color="60,110,170")
    studio.add_actor("vehicle.gazelle.omafiets", 8.0, -3.4, color="120,20,20")
    studio.walk(studio.add_actor("walker.pedestrian.0016", 9.0, 3.4, 180.0), 1.0)
    return studio.view(right_m=-1.6)


def _weather(**values: float) -> Callable[[Studio], CameraView]:
    def scene(studio: Studio) -> CameraView:
        studio.weather(**values)
        return _street(studio)

    return scene


def _lights(studio: Studio) -> CameraView:
    studio.add_actor("vehicle.lincoln.mkz_2020", 7.0, -3.4, lights=BRAKE, color="88,88,88")
    studio.add_actor("vehicle.tesla.model3", 7.0, 0.2, lights=RIGHT | LEFT, color="22,62,120")
    studio.add_actor("vehicle.nissan.patrol_2021", 10.0, -7.2, lights=REVERSE, color="255,255,255")
    studio.add_actor("vehicle.audi.etron", 17.0, -1.9, lights=LEFT, color="178,174,162")
    return studio.view(right_m=-2.2, ticks=2)


def _door(studio: Studio) -> CameraView:
    car = studio.add_actor("vehicle.lincoln.mkz_2020", 6.8, 0.4, color="180,44,44")
    studio.world.doors.move(car.row, car.box, 0, True)
    other = studio.add_actor("vehicle.mini.cooper_s_2021", 8.0, -6.0, 180.0, color="178,174,162")
    studio.world.doors.move(other.row, other.box, ALL, True)
    return studio.view(right_m=-1.8)


def _cones(studio: Studio) -> CameraView:
    for number in range(5):
        studio.add_actor("static.prop.trafficcone01", 6.0 + 2.2 * number, 1.4 - 0.8 * number)
    for number in range(3):
        studio.add_actor("static.prop.streetbarrier", 13.0, -0.4 + 1.4 * number, 90.0)
    studio.add_actor("static.prop.warningconstruction", 5.0, -2.6, 180.0)
    studio.add_actor("static.prop.trafficwarning", 19.0, 0.6, 180.0)
    studio.add_actor("static.prop.constructioncone", 4.6, 0.6)
    return studio.view(right_m=-1.0, pitch_deg=-8.0)


def _litter(studio: Studio) -> CameraView:
    rows = ("paperbag", "rock", "cardboardbox"), ("plasticbag", "tyre", "dirtdebris01"), ("box01", "trashbag", "ball")
    for row, names in enumerate(rows):
        for column, name in enumerate(names):
            studio.add_actor(f"static.prop.{name}", 2.9 + 1.7 * row, -2.3 + 1.6 * column + 0.2 * row, 160.0)
    return studio.view(right_m=-0.7, up_m=1.4, pitch_deg=-18.0)


def _cyclist(studio: Studio) -> CameraView:
    studio.add_actor("vehicle.gazelle.omafiets", 5.4, -2.2, 62.0, color="22,62,120")
    studio.add_actor("vehicle.bh.crossbike", 6.0, -4.9, 140.0, color="120,20,20")
    studio.add_actor("vehicle.kawasaki.ninja", 6.0, 0.5, 40.0, color="60,140,60")
    studio.add_actor("vehicle.vespa.zx125", 6.0, 2.8, 240.0, color="230,230,220")
    return studio.view(right_m=-1.0, up_m=1.5, ticks=2)


def _van(studio: Studio) -> CameraView:
    studio.add_actor("vehicle.mercedes.sprinter", 10.0, 1.2, color="255,255,255")
    studio.walk(studio.add_actor("walker.pedestrian.0003", 5.2, -2.0, -90.0), 1.0)
    studio.add_actor("walker.pedestrian.0011", 8.4, -0.9, 180.0)
    return studio.view(right_m=-1.4, ticks=10)


def _ambulance(studio: Studio) -> CameraView:
    studio.add_actor("vehicle.ford.ambulance", 11.0, -3.4, 195.0, lights=FLASH | LOW, color="255,255,255")
    studio.add_actor("vehicle.dodge.charger_police_2020", 9.5, 1.2, -35.0, lights=FLASH, color="255,255,255")
    studio.add_actor("vehicle.carlamotors.firetruck", 22.0, -0.5, 160.0, lights=FLASH)
    studio.add_actor("static.prop.warningaccident", 5.0, -0.9, 180.0)
    return studio.view(right_m=-1.4, up_m=2.0)


def _flagger(studio: Studio) -> CameraView:
    studio.add_actor("walker.flagger.0001", 6.0, -2.2, 180.0, gesture="stop")
    studio.add_actor("walker.flagger.0001", 6.0, 0.9, 180.0, gesture="slow")
    for number in range(3):
        studio.add_actor("static.prop.constructioncone", 7.0 + 2 * number, -0.7)
    studio.add_actor("vehicle.carlamotors.carlacola", 18.0, 0.6)
    return studio.view(right_m=-0.6, up_m=1.6)


def _school_bus(studio: Studio) -> CameraView:
    bus = studio.add_actor("vehicle.carlette.schoolbus", 11.5, 0.2, lights=FLASH | BRAKE)
    studio.world.doors.move(bus.row, bus.box, STOP_ARM, True)
    studio.walk(studio.add_actor("walker.pedestrian.0010", 6.5, 3.6, 0.0), 0.8)
    studio.add_actor("vehicle.audi.a2", 20.0, -7.0, 180.0, color="88,88,88")
    return studio.view(right_m=-2.2, up_m=1.8, pitch_deg=-1.0)


def _crossing(studio: Studio) -> CameraView:
    studio.add_actor("static.prop.crossinggatepost", 9.0, 3.0, 180.0)
    studio.add_actor("static.prop.crossinggate", 9.0, 2.8, 180.0)
    studio.add_actor("static.prop.crossinggatepost", 12.0, -8.2, 0.0)
    studio.add_actor("static.prop.crossinggate", 12.0, -8.0, 0.0)
    return studio.view(right_m=-1.2)


def _animals(studio: Studio) -> CameraView:
    for number, name in enumerate(("cat", "dog", "deer", "cow", "horse", "goose")):
        actor = studio.add_actor(
            f"animal.{name}",
            5.0 + 1.9 * (number == 3) + 3.6 * (number == 4),
            -4.2 + 1.55 * number,
            (120, 60, 200, 70, 120, 90)[number],
        )
        studio.walk(actor, 0.6)
    return studio.view(right_m=-0.6, up_m=1.4, ticks=4)


def _kinds(*ids: str) -> Callable[[Studio], CameraView]:
    def scene(studio: Studio) -> CameraView:
        colors = ("180,44,44", "22,62,120", "255,255,255", "178,174,162", "60,140,80", "88,88,88")
        for number, type_id in enumerate(ids):
            row, column = divmod(number, 2)
            color = "255,255,255" if "police" in type_id or "ambulance" in type_id else colors[number]
            turn = 35.0 + 180.0 * ((number + row) % 2)
            studio.add_actor(type_id, 9.0 + 10.5 * row, -6.0 + 6.6 * column - 0.5 * row, turn, color=color)
        return studio.view(right_m=-2.6, up_m=3.4, pitch_deg=-10.0, ticks=2)

    return scene


def _props(studio: Studio) -> CameraView:
    names = (
        "container",
        "bench01",
        "vendingmachine",
        "busstop",
        "haybale",
        "advertisement",
        "trashcan01",
        "foodcart",
        "table",
    )
    for number, name in enumerate(names):
        row, column = divmod(number, 3)
        studio.add_actor(f"static.prop.{name}", 6.5 + 5.0 * row, -6.0 + 3.8 * column + 0.6 * row, 180.0)
    return studio.view(right_m=-2.0, up_m=2.4, pitch_deg=-10.0, ticks=2)


def _signs(studio: Studio) -> CameraView:
    wanted = (
        ("206", ""),
        ("205", ""),
        ("274", "30"),
        ("274", "90"),
        ("101", ""),
        ("267", ""),
        ("306", ""),
        ("350", ""),
    )
    for number, (kind, value) in enumerate(wanted):
        place = studio.pose_at(6.0, -5.2 + 1.4 * number, 0.0, 180.0)
        studio.extra.append(RenderPart(post_sign(kind, value), matrix_of(place), 0, tags.TRAFFIC_SIGN))
    return studio.view(right_m=-0.4, up_m=1.7, pitch_deg=2.0, ticks=1)


def _traffic_light(color: Color) -> Callable[[Studio], CameraView]:
    def scene(studio: Studio) -> CameraView:
        lights = [actor for actor in studio.world.actors.values() if actor.kind is ActorKind.LIGHT]
        for light in lights:
            studio.world.signals.set_color(light.index, color if light is lights[0] else Color.RED)
        pose = studio.world.pose(lights[0])
        stop = pose.apply(lights[0].box.center)
        studio.spot = Pose(stop, Rotation(0.0, pose.rotation.yaw - 90.0, 0.0))
        return studio.view(-8.0, 0.0, 1.7, 0.0, ticks=1)

    return scene


_WEATHER = {
    "cloudiness": CLOUDINESS, "precipitation": PRECIPITATION, "deposits": DEPOSITS, "wetness": WETNESS,
    "azimuth": SUN_AZIMUTH, "altitude": SUN_ALTITUDE, "fog": FOG_DENSITY,
}  # fmt: skip
SCENES: dict[str, tuple[Callable[[Studio], CameraView], str]] = {
    "clear": (_weather(), "rgb"),
    "cloudy": (_weather(cloudiness=70.0), "rgb"),
    "sunset": (_weather(cloudiness=20.0, altitude=4.0, azimuth=10.0), "rgb"),
    "night": (_weather(altitude=-40.0), "rgb"),
    "rain": (_weather(cloudiness=95.0, precipitation=80.0, deposits=70.0, wetness=100.0, fog=8.0), "rgb"),
    "fog": (_weather(cloudiness=60.0, fog=65.0), "rgb"),
    "night_rain": (
        _weather(altitude=-40.0, cloudiness=95.0, precipitation=70.0, deposits=70.0, wetness=100.0, fog=10.0),
        "rgb",
    ),
    "semantic": (_weather(), "semantic"),
    "instance": (_weather(), "instance"),
    "depth": (_weather(), "depth"),
    "lights": (_lights, "rgb"),
    "traffic_light_red": (_traffic_light(Color.RED), "rgb"),
    "traffic_light_green": (_traffic_light(Color.GREEN), "rgb"),
    "signs": (_signs, "rgb"),
    "open_door": (_door, "rgb"),
    "cones": (_cones, "rgb"),
    "litter": (_litter, "rgb"),
    "cyclist": (_cyclist, "rgb"),
    "van": (_van, "rgb"),
    "ambulance": (_ambulance, "rgb"),
    "flagger": (_flagger, "rgb"),
    "school_bus": (_school_bus, "rgb"),
    "level_crossing": (_crossing, "rgb"),
    "animals": (_animals, "rgb"),
    "cars": (
        _kinds(
            "vehicle.lincoln.mkz_2020", "vehicle.mini.cooper_s_2021", "vehicle.nissan.patrol_2021",
            "vehicle.ford.mustang", "vehicle.ford.crown", "vehicle.tesla.cybertruck",
        ),
        "rgb",
    ),
    "large_vehicles": (
        _kinds(
            "vehicle.mercedes.sprinter", "vehicle.volkswagen.t2_2021", "vehicle.ford.ambulance",
            "vehicle.carlamotors.european_hgv", "vehicle.carlamotors.carlacola", "vehicle.mitsubishi.fusorosa",
        ),
        "rgb",
    ),
    "props": (_props, "rgb"),
}  # fmt: skip
"""Scene and camera of each picture, by name."""

PALETTE = np.zeros((256, 3), np.uint8)
"""Colors of the tags, as in CARLA's `CityScapesPalette`."""
PALETTE[:29] = (
    (0, 0, 0), (128, 64, 128), (244, 35, 232), (70, 70, 70), (102, 102, 156), (190, 153, 153), (153, 153, 153),
    (250, 170, 30), (220, 220, 0), (107, 142, 35), (152, 251, 152), (70, 130, 180), (220, 20, 60), (255, 0, 0),
    (0, 0, 142), (0, 0, 70), (0, 60, 100), (0, 80, 100), (0, 0, 230), (119, 11, 32), (110, 190, 160), (170, 120, 50),
    (55, 90, 80), (45, 60, 150), (157, 234, 50), (81, 0, 81), (150, 100, 100), (230, 150, 140), (180, 165, 180),
)  # fmt: skip


def draw(name: str, network: RoadNetwork) -> Bytes:
    """Return one picture of the gallery, (450, 800, 3) red, green, blue."""
    scene, kind = SCENES[name]
    studio = Studio(network)
    view = scene(studio)
    return studio.shoot(view, kind)


def main(arguments: list[str] | None = None) -> int:
    """Draw the pictures as JPEG files."""
    parser = argparse.ArgumentParser(prog="python -m carlette.tools.gallery", description="Draws sample pictures.")
    parser.add_argument("--out", type=Path, required=True, help="folder for the pictures")
    parser.add_argument("--only", nargs="*", choices=sorted(SCENES), help="names; all when left out")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    from PIL import Image  # drawing needs no pillow, only files do

    network = RoadNetwork(load_map(DEMO_TOWN))
    for name in options.only or SCENES:
        picture = Image.fromarray(np.ascontiguousarray(draw(name, network)))
        picture.save(options.out / f"{name}.jpg", quality=QUALITY)
        print(options.out / f"{name}.jpg")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
