"""What cameras promise besides their geometry: the same picture for the same world, and a place beside the road."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import psutil
import pytest
import shapely

from carlette.camera.environment.road_surface import pave
from carlette.camera.environment.sampled_roads import read_roads
from carlette.camera.environment.scenery import scenery
from carlette.camera.environment.static_scene import build_static_scene
from carlette.camera.rendering.renderer import Renderer
from carlette.camera.rendering.scene_capture import encode_depth, notice, take
from carlette.camera.rendering.view import CameraView
from carlette.geometry import Pose, Rotation, Vector
from carlette.opendrive.map_file import check_opendrive
from carlette.world.settings import CLEAR_NOON
from carlette.world.world import World
from conftest import Camera
from straight import add

FRAMES, WARM, GROWTH_MB = 1000, 200, 5.0


@pytest.mark.integration
def test_the_same_world_gives_the_same_bytes(world) -> None:
    for number in range(4):
        add(world, x=40.0 + 9.0 * number)
    copy = world.fork()
    assert (Camera(world).rgb() == Camera(copy).rgb()).all()


@pytest.mark.integration
def test_a_stage_is_built_the_same_way_again(town) -> None:
    for chunk, other in zip(build_static_scene(town).chunks, build_static_scene(town).chunks, strict=True):
        assert chunk.center == other.center and list(chunk.layers) == list(other.layers)
        for name, mesh in chunk.layers.items():
            assert (mesh.corners == other.layers[name].corners).all()
            assert (mesh.colors == other.layers[name].colors).all()


def test_pictures_do_not_depend_on_what_was_drawn_before(world) -> None:
    add(world, x=45.0)
    camera = Camera(world)
    first = camera.rgb()
    world.weather = (*CLEAR_NOON[:5], -40.0, *CLEAR_NOON[6:])
    camera.rgb()
    world.weather = CLEAR_NOON
    assert (camera.rgb() == first).all()


def test_threads_do_not_disturb_each_other(world) -> None:
    add(world, x=45.0)
    cameras = [Camera(world, yaw=30.0 * number, size=(160 + 32 * number, 90)) for number in range(4)]
    alone = [camera.rgb() for camera in cameras]
    with ThreadPoolExecutor(4) as pool:
        for _ in range(5):
            together = list(pool.map(Camera.rgb, cameras))
            assert all((item == other).all() for item, other in zip(alone, together, strict=True))


@pytest.mark.integration
def test_nothing_at_body_height_stands_on_a_lane(town) -> None:
    pavement = pave(read_roads(check_opendrive(town.file.text, "town")))
    items = scenery(pavement, 1, [])
    lanes = shapely.STRtree(shapely.polygons(np.concatenate(pavement.lanes)))
    assert len(items) > 100
    for item in items:
        low = item.base.corners.reshape(-1, 3)
        low = low[low[:, 2] < 2.2]
        if len(low):
            assert not len(lanes.query(shapely.MultiPoint(low[:, :2]).convex_hull, predicate="intersects"))


@pytest.mark.integration
def test_another_map_has_other_scenery(town) -> None:
    pavement = pave(read_roads(check_opendrive(town.file.text, "town")))
    one, other = ([item.place for item in scenery(pavement, seed, [])] for seed in (1, 2))
    assert one != other


def test_a_camera_inside_its_car_does_not_see_that(world) -> None:
    car = add(world, x=40.0)
    for height, is_seen in ((1.0, False), (1.8, True)):
        eye = Vector(39.5, 1.75, height)
        view = CameraView(Pose(eye, Rotation(-30.0, 0.0, 0.0)), 160, 90, 90.0)
        shot = notice(world).from_inside(world, car, eye).shot()
        seen = Renderer().instances(shot, view)[..., 1]
        assert (seen == car.id).any() == is_seen


@pytest.mark.parametrize("meters", (0.1, 3.7, 42.0, 999.0, 1000.0, 5000.0))
def test_depth_can_be_decoded_as_carla_says(meters) -> None:
    blue, green, red, alpha = encode_depth(np.full((1, 1), meters, np.float32))[0, 0].astype(int).tolist()
    assert alpha == 255
    assert (red + 256 * green + 65536 * blue) / 0xFFFFFF * 1000 == pytest.approx(min(meters, 1000.0), abs=1e-3)


@pytest.mark.integration
def test_a_crowd_of_cameras_leaves_the_world_alone(town) -> None:
    one, other = World(town), World(town)
    add(one, x=50.0)
    add(other, x=50.0)
    for _ in range(5):
        one.tick()
        other.tick()
        Renderer().rgb(take(one), CameraView(Pose(Vector(40.0, 0.0, 3.0)), 64, 36, 90.0))
    assert one.bodies.record.tobytes() == other.bodies.record.tobytes()


@pytest.mark.release
@pytest.mark.integration
def test_memory_is_flat_over_a_thousand_frames(world) -> None:
    for number in range(6):
        add(world, x=60.0 + 9.0 * number)
    process, renderer = psutil.Process(), Renderer()
    for number in range(FRAMES):
        if number == WARM:
            warm = process.memory_info().rss
        if number % 10 == 0:
            world.weather = (number % 100, *CLEAR_NOON[1:5], 45.0 - number % 7, *CLEAR_NOON[6:])
        world.tick()
        size = ((64, 36), (96, 54), (48, 48))[number % 3]
        view = CameraView(Pose(Vector(50.0 + number % 40, -1.75, 2.0), Rotation(0.0, number, 0.0)), *size, 90.0)
        shot = take(world)
        renderer.rgb(shot, view)
        if number % 5 == 0:
            renderer.depth(shot, view)
            renderer.tags(shot, view)
    assert (process.memory_info().rss - warm) / 1e6 < GROWTH_MB
