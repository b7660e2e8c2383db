"""What a driver's front camera shows: the light that holds the car, and nothing of the car that floats."""

from __future__ import annotations

import numpy as np
import pytest

from carlette.camera.environment.repeater_lights import eyes, is_in_sight, repeaters_of
from carlette.camera.models.lamps import VehicleLights
from carlette.camera.models.traffic_lights import REPEATER_HEAD, heads
from carlette.camera.rendering.renderer import Renderer
from carlette.camera.rendering.scene_capture import notice, take
from carlette.camera.rendering.view import CameraView
from carlette.geometry import Pose, Rotation, Vector
from carlette.opendrive.map_file import check_opendrive, find_map, map_folders
from carlette.opendrive.road_network import RoadNetwork
from carlette.opendrive.signals import LIGHT_TYPE, read_signals
from carlette.world.actor import ActorKind
from carlette.world.traffic_lights import Color
from carlette.world.world import World
from conftest import Camera
from straight import add

pytestmark = pytest.mark.integration

SEEN_AS = {Color.RED: 0, Color.GREEN: 1}
"""The strongest channel (red, green, blue) of a lit lamp."""


def lights_of(roads: RoadNetwork) -> list:
    signals = read_signals(roads, check_opendrive(roads.file.text, roads.file.name))
    return [signal for signal in signals if signal.type == LIGHT_TYPE]


@pytest.mark.parametrize("name", ["demo_town", "grid_town", "Town01", "Town02", "Town04", "Town10HD"])
def test_traffic_light_head_is_visible_from_each_stop_line(name: str) -> None:
    """Each traffic light has a head in the view of each car at its stop line."""
    folders = map_folders([])
    if name.startswith("Town") and not any((folder / f"{name}.xodr").is_file() for folder in folders):
        pytest.skip(f"needs {name}.xodr in a folder of STUCKSOLVER_MAPS")
    roads = RoadNetwork(find_map(name, folders))
    lights = lights_of(roads)
    assert lights
    for light, foot in zip(lights, repeaters_of(roads), strict=True):
        places = heads(round(light.box.center.x, 1))
        if foot is not None:
            places.append((foot[0], foot[1], foot[2] + REPEATER_HEAD[2]))
        assert all(any(is_in_sight(eye, place) for place in places) for eye in eyes(light)), light.id


def test_a_second_post_stands_beside_all_driving_lanes(town) -> None:
    for light, foot in zip(lights_of(town), repeaters_of(town), strict=True):
        if foot is not None:
            place = light.pose.apply(Vector(*foot))
            lane = town.map.get_waypoint(town.carla.Location(*place), True, town.carla.LaneType.Driving)
            middle = lane.transform.location
            assert np.hypot(place.x - middle.x, place.y - middle.y) > lane.lane_width / 2 + 0.5


@pytest.mark.parametrize("color", [Color.RED, Color.GREEN])
def test_the_first_cars_camera_shows_the_color_of_its_light(town, color: Color) -> None:
    world = World(town)
    for light in [actor for actor in world.actors.values() if actor.kind is ActorKind.LIGHT]:
        pose = world.pose(light)
        signal = next(item for item in lights_of(town) if item.pose.location == pytest.approx(pose.location, abs=0.01))
        for eye in eyes(signal):
            world.signals.set_color(light.index, color)
            view = CameraView(
                Pose(pose.apply(Vector(*eye)), Rotation(0.0, pose.rotation.yaw - 90.0, 0.0)), 800, 450, 90.0
            )
            renderer = Renderer()
            seen = renderer.rgb(take(world), view)[..., 2::-1].astype(int)
            codes = renderer.instances(take(world), view).astype(int)
            lamps = seen[codes[..., 1] + 256 * codes[..., 0] == light.id]
            strong = (lamps[:, SEEN_AS[color]] > 200) & (lamps[:, 1 - SEEN_AS[color]] < 245) & (lamps.min(axis=1) < 130)
            assert strong.sum() >= 8, (light.id, color)


@pytest.mark.parametrize("kind", ["vehicle.lincoln.mkz_2020", "vehicle.tesla.model3", "vehicle.audi.tt"])
@pytest.mark.parametrize("x", [0.7, 0.8])
def test_no_lamp_floats_before_a_front_camera(world, kind: str, x: float) -> None:
    car = add(world, kind, x=40.0)
    world.fleet.light_state[car.index] = int(
        VehicleLights.LOW_BEAM | VehicleLights.LEFT_BLINKER | VehicleLights.RIGHT_BLINKER
    )
    pose = world.pose(car).compose(Pose(Vector(x, 0.0, 1.6)))
    shot = notice(world).from_inside(world, car, pose.location).shot()
    picture = Renderer().rgb(shot, CameraView(pose, 800, 450, 90.0))
    bare = Camera(world, x=pose.location.x, y=pose.location.y, z=pose.location.z, size=(800, 450))
    world.remove(car.id)
    assert np.abs(picture[..., 2::-1].astype(int) - bare.rgb())[:440].max() == 0


def test_camera_inside_vehicle_sees_only_cast_light(world) -> None:
    """A camera inside a vehicle sees no part of that vehicle but the light that it casts."""
    van = add(world, "vehicle.mercedes.sprinter", x=40.0)
    inside = notice(world).from_inside(world, van, world.pose(van).apply(Vector(0.8, 0.0, 1.6)))
    assert all(part.adds for part in inside.parts if part.actor_id == van.id)


@pytest.mark.parametrize(
    ("flag", "behind", "color"),
    [
        (VehicleLights.BRAKE, True, (255, 26, 16)),
        (VehicleLights.LEFT_BLINKER, True, (255, 158, 0)),
        (VehicleLights.LOW_BEAM, False, (255, 252, 236)),
    ],
)
def test_a_motorcycle_shows_its_light_state(
    world, flag: VehicleLights, behind: bool, color: tuple[int, int, int]
) -> None:
    bike = add(world, "vehicle.yamaha.yzf", x=34.0, yaw=0.0 if behind else 180.0)
    camera = Camera(world, size=(640, 360))

    def lit() -> int:
        return int((np.abs(camera.rgb() - np.array(color)).max(axis=2) < 30)[camera.ids() == bike.id].sum())

    before = lit()
    world.fleet.light_state[bike.index] = int(flag)
    assert lit() >= before + 6
