"""The real client gets the cameras' pictures, each of the tick's own frame."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from conftest import Camera  # noqa: F401  (skips where the renderer is missing)
from serving import running_server

carla = pytest.importorskip("carla")
pytestmark = pytest.mark.integration

WAIT_S = 30.0


@pytest.fixture(scope="module")
def world() -> Iterator[Any]:
    version = carla.Client("127.0.0.1", 1, 1).get_client_version()
    with running_server("--map", "demo_town", "--client-version", version) as port:
        client = carla.Client("127.0.0.1", port)
        client.set_timeout(WAIT_S)
        found = client.get_world()
        settings = found.get_settings()
        settings.synchronous_mode, settings.fixed_delta_seconds = True, 0.05
        found.apply_settings(settings)
        yield found


@pytest.fixture
def ego(world: Any) -> Iterator[Any]:
    blueprint = world.get_blueprint_library().find("vehicle.lincoln.mkz_2020")
    car = world.spawn_actor(blueprint, world.get_map().get_spawn_points()[20])
    yield car
    car.destroy()
    world.tick()


def cameras(
    world: Any, ego: Any, kinds: list[str], size: tuple[int, int], step_deg: float = 60.0, pitch_deg: float = 0.0
) -> tuple[list[Any], list[Any]]:
    """Cameras on the roof of the car, each turned by `step_deg` more, and the queues that they fill."""
    found, queues = [], []
    for number, kind in enumerate(kinds):
        blueprint = world.get_blueprint_library().find(f"sensor.camera.{kind}")
        for name, value in (("image_size_x", size[0]), ("image_size_y", size[1]), ("fov", 100)):
            blueprint.set_attribute(name, str(value))
        place = carla.Transform(carla.Location(0.0, 0.0, 2.2), carla.Rotation(pitch=pitch_deg, yaw=step_deg * number))
        found.append(world.spawn_actor(blueprint, place, attach_to=ego))
        queues.append(queue.Queue())
        found[-1].listen(queues[-1].put)
    return found, queues


def end(found: list[Any]) -> None:
    for item in found:
        item.stop()
        item.destroy()


def pixels(image: Any) -> np.ndarray:
    return np.frombuffer(image.raw_data, np.uint8).reshape(image.height, image.width, 4)


@pytest.mark.slow
def test_six_large_cameras_each_have_the_ticks_frame(world, ego) -> None:
    found, queues = cameras(world, ego, ["rgb"] * 6, (1600, 900))
    try:
        for _ in range(3):
            frame = world.tick()
            images = [item.get(timeout=WAIT_S) for item in queues]
            assert [image.frame for image in images] == [frame] * 6
            assert {(image.width, image.height, round(image.fov)) for image in images} == {(1600, 900, 100)}
        assert all(len(np.unique(pixels(image)[::20, ::20, :3].reshape(-1, 3), axis=0)) > 20 for image in images)
    finally:
        end(found)


def test_the_four_kinds_show_the_same_street(world, ego) -> None:
    kinds = ["rgb", "depth", "semantic_segmentation", "instance_segmentation"]
    found, queues = cameras(world, ego, kinds, (320, 180), 0.0, -5.0)
    try:
        world.tick()
        _, depth, semantic, instance = (item.get(timeout=WAIT_S) for item in queues)
        coded = pixels(depth).astype(int)
        meters = (coded[..., 2] + 256 * coded[..., 1] + 65536 * coded[..., 0]) / 0xFFFFFF * 1000
        tags = pixels(semantic)[..., 2]
        assert (tags == pixels(instance)[..., 2]).all()
        assert meters[tags == 11].min() > 990.0
        assert {1, 2, 11, 24} <= set(np.unique(tags).tolist())
        assert meters[-1][tags[-1] == 1].max() < 30.0
    finally:
        end(found)


def test_an_absurd_picture_is_refused_by_name(world, ego) -> None:
    blueprint = world.get_blueprint_library().find("sensor.camera.rgb")
    blueprint.set_attribute("image_size_x", "100000")
    with pytest.raises(RuntimeError, match="image_size_x"):
        world.spawn_actor(blueprint, carla.Transform(), attach_to=ego)
