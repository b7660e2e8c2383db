"""A map whose scenery takes long to build: nobody's requests wait for it, and no measurement is lost."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path
from queue import Empty, Queue
from typing import Any

import pytest
from serving import running_server

carla = pytest.importorskip("carla")
pytestmark = pytest.mark.integration

BUILD_S = 7.0
CLIENT_TIMEOUT_S = 5.0
LONG_S = 120.0
SLOW_BUILDER = f"""
import time
from carlette import cli
from carlette.camera.rendering import shots as studio
build = studio.build_static_scene
def slowly(roads):
    time.sleep({BUILD_S})
    return build(roads)
studio.build_static_scene = slowly
cli.main()
"""


@pytest.fixture(scope="module")
def slow_port() -> Iterator[int]:
    with running_server("--map", "demo_town", *_version(), program=("-c", SLOW_BUILDER)) as port:
        yield port


def test_requests_are_answered_while_a_map_is_built_and_the_first_frame_comes_after_it(slow_port: int) -> None:
    world, other = _world(slow_port), _world(slow_port)
    _make_synchronous(world)
    begun = time.monotonic()
    camera, pictures = _listening(world, "sensor.camera.rgb")
    lidar, scans = _listening(world, "sensor.lidar.ray_cast")
    answered = time.monotonic()
    frames = [world.tick() for _ in range(3)]
    with pytest.raises(Empty):  # the world goes on; the picture is not made up
        pictures.get(timeout=0.05)
    assert other.get_snapshot().frame == frames[-1]
    assert answered - begun < BUILD_S
    # The client hands what arrives together to several threads of its own, so their order is not the server's.
    assert sorted(pictures.get(timeout=LONG_S) for _ in frames) == frames
    assert sorted(scans.get(timeout=LONG_S) for _ in frames) == frames
    assert pictures.empty() and scans.empty()
    for one in (camera, lidar):
        one.destroy()


def test_with_its_scenery_built_before_it_listens_a_first_tick_brings_a_picture() -> None:
    """Without the option the first picture of this server comes seconds later, as the test above shows."""
    with running_server("--map", "demo_town", "--build-scenery", *_version(), program=("-c", SLOW_BUILDER)) as port:
        world = _world(port)
        _make_synchronous(world)
        camera, pictures = _listening(world, "sensor.camera.rgb")
        frame = world.tick()
        assert pictures.get(timeout=CLIENT_TIMEOUT_S) == frame
        camera.destroy()


def test_a_server_ends_at_once_while_a_map_is_built() -> None:
    with running_server("--map", "demo_town", *_version(), program=("-c", SLOW_BUILDER.replace("7.0", "60.0"))) as port:
        world = _world(port)
        sensor, _ = _listening(world, "sensor.camera.rgb")
        sensor.stop()
        # The block's end asserts that it goes within 10 s.


def test_in_asynchronous_mode_pictures_begin_when_the_map_is_built(slow_port: int) -> None:
    client = carla.Client("127.0.0.1", slow_port)
    client.set_timeout(CLIENT_TIMEOUT_S)
    world = client.load_world("grid_town")
    camera, pictures = _listening(world, "sensor.camera.rgb")
    first = pictures.get(timeout=LONG_S)
    newest = world.get_snapshot().frame
    assert newest - first < 20 * BUILD_S / 2  # none of the ticks before is drawn after all
    camera.destroy()


def test_the_first_measurements_on_the_largest_town_are_of_the_first_tick() -> None:
    folders = [Path(one) for one in os.environ.get("STUCKSOLVER_MAPS", "").split(os.pathsep) if one]
    if not any((one / "Town04.xodr").is_file() for one in folders):
        pytest.skip("needs Town04.xodr in a folder of STUCKSOLVER_MAPS")
    with running_server("--map", "Town04", *_version()) as port:
        world = _world(port)
        _make_synchronous(world)
        kinds = ("sensor.camera.rgb", "sensor.lidar.ray_cast_semantic", "sensor.other.imu")
        listening = [_listening(world, kind) for kind in kinds]
        frame = world.tick()
        assert [frames.get(timeout=LONG_S) for _, frames in listening] == [frame] * len(kinds)
        for sensor, _ in listening:
            sensor.destroy()


def _version() -> tuple[str, str]:
    return "--client-version", carla.Client("127.0.0.1", 1, 1).get_client_version()


def _world(port: int) -> Any:
    client = carla.Client("127.0.0.1", port)
    client.set_timeout(CLIENT_TIMEOUT_S)
    return client.get_world()


def _make_synchronous(world: Any) -> None:
    settings = world.get_settings()
    settings.synchronous_mode, settings.fixed_delta_seconds = True, 0.05
    world.apply_settings(settings)


def _listening(world: Any, type_id: str) -> tuple[Any, Queue[int]]:
    queue: Queue[int] = Queue()
    place = world.get_map().get_spawn_points()[0]
    sensor = world.spawn_actor(world.get_blueprint_library().find(type_id), place)
    sensor.listen(lambda data: queue.put(data.frame))
    return sensor, queue
