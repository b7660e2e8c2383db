"""A map whose scenery takes long to build: nobody's requests wait for it, and no measurement is lost."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from queue import Empty, Queue
from typing import Any

import pytest

from serving import running_server

carla = pytest.importorskip("carla")
pytestmark = pytest.mark.integration

LONG_S = 120.0
"""Who takes longer than that hangs."""
ASYNCHRONOUS_HZ = 20
GATED_BUILDER = """
import os, sys, time
from carlette import cli
from carlette.camera.rendering import scene_capture as studio
gate, build = sys.argv.pop(1), studio.build_static_scene
def slowly(roads):
    while not os.path.exists(gate):
        time.sleep(0.02)
    return build(roads)
studio.build_static_scene = slowly
cli.main()
"""


class Gate:
    """Nothing is built while it is shut; a server with this gate passes it whenever it builds a map."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self.program = ("-c", GATED_BUILDER, str(file))

    def open(self) -> None:
        self._file.touch()

    def shut(self) -> None:
        self._file.unlink(missing_ok=True)


@pytest.fixture(scope="module")
def _gated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[int, Gate]]:
    gate = Gate(tmp_path_factory.mktemp("gate") / "open")
    with running_server("--map", "demo_town", *_version(), program=gate.program) as port:
        yield port, gate


@pytest.fixture
def gated(_gated: tuple[int, Gate]) -> tuple[int, Gate]:
    """A server's port and its gate, which is shut."""
    _gated[1].shut()
    return _gated


@pytest.mark.slow
def test_scenery_build_blocks_no_request_and_loses_no_frame(gated: tuple[int, Gate]) -> None:
    """Requests are answered while a map is built, and all frames from the first are delivered afterwards."""
    port, gate = gated
    world, other = _world(port), _world(port)
    _make_synchronous(world)
    # Each of these requests would wait for ever if it waited for the map.
    camera, pictures = _listening(world, "sensor.camera.rgb")
    lidar, scans = _listening(world, "sensor.lidar.ray_cast")
    frames = [world.tick() for _ in range(3)]
    with pytest.raises(Empty):  # the world goes on; the picture is not made up
        pictures.get(timeout=0.05)
    assert other.get_snapshot().frame == frames[-1]
    gate.open()
    # The client hands what arrives together to several threads of its own, so their order is not the server's.
    assert sorted(pictures.get(timeout=LONG_S) for _ in frames) == frames
    assert sorted(scans.get(timeout=LONG_S) for _ in frames) == frames
    assert pictures.empty() and scans.empty()
    for item in (camera, lidar):
        item.destroy()


def test_scenery_built_at_start_gives_image_at_first_tick(tmp_path: Path) -> None:
    """With --build-scenery, the first tick gives an image.

    Without the option this picture would wait for a map that is not built any more.
    """
    gate = Gate(tmp_path / "open")
    gate.open()
    with running_server("--map", "demo_town", "--build-scenery", *_version(), program=gate.program) as port:
        gate.shut()
        world = _world(port)
        _make_synchronous(world)
        camera, pictures = _listening(world, "sensor.camera.rgb")
        frame = world.tick()
        assert pictures.get(timeout=LONG_S) == frame
        camera.destroy()


@pytest.mark.slow
def test_a_server_ends_while_a_map_is_built(tmp_path: Path) -> None:
    with running_server("--map", "demo_town", *_version(), program=Gate(tmp_path / "open").program) as port:
        world = _world(port)
        sensor, _ = _listening(world, "sensor.camera.rgb")
        sensor.stop()
        # The block's end asserts that it goes, though the map is never built.


@pytest.mark.release
@pytest.mark.slow
def test_in_asynchronous_mode_pictures_begin_when_the_map_is_built(gated: tuple[int, Gate]) -> None:
    port, gate = gated
    client = carla.Client("127.0.0.1", port)
    client.set_timeout(LONG_S)
    world = client.load_world("grid_town")
    camera, pictures = _listening(world, "sensor.camera.rgb")
    begun = world.wait_for_tick().frame
    while (shut_until := world.wait_for_tick().frame) < begun + ASYNCHRONOUS_HZ:
        pass
    gate.open()
    assert pictures.get(timeout=LONG_S) > shut_until  # none of the ticks before is drawn after all
    camera.destroy()


@pytest.mark.release
def test_scenery_largest_town_first_measurements_are_of_first_tick() -> None:
    """On the largest town, the first measurements of camera, LiDAR and IMU are of the first tick."""
    folders = [Path(item) for item in os.environ.get("STUCKSOLVER_MAPS", "").split(os.pathsep) if item]
    if not any((folder / "Town04.xodr").is_file() for folder in folders):
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
    client.set_timeout(LONG_S)
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
