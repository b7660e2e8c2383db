"""Worlds to be photographed, and what is asked of a picture."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("carla")

from carlette.camera.rendering.actor_parts import cast
from carlette.camera.rendering.lighting import light_of
from carlette.camera.rendering.renderer import CapturedScene, Renderer
from carlette.camera.rendering.scene_capture import static_scene_of
from carlette.camera.rendering.view import CameraView, matrix_of
from carlette.geometry import Pose, Rotation, Vector
from carlette.maps import DEMO_TOWN
from carlette.opendrive.map_file import MapFile, load_map
from carlette.opendrive.road_network import RoadNetwork
from carlette.world.world import World
from straight import straight_road


@pytest.fixture(scope="session")
def straight() -> RoadNetwork:
    return RoadNetwork(MapFile("straight", straight_road()))


@pytest.fixture
def world(straight) -> World:
    """A straight, level road along +x."""
    return World(straight)


@pytest.fixture(scope="session")
def town() -> RoadNetwork:
    return RoadNetwork(load_map(DEMO_TOWN))


class Camera:
    """A camera above the lane of the straight road, looking along it."""

    def __init__(self, world, x=30.0, y=1.75, z=1.6, pitch=0.0, yaw=0.0, fov=90.0, size=(320, 180)) -> None:
        self.world = world
        self.view = CameraView(Pose(Vector(x, y, z), Rotation(pitch, yaw, 0.0)), *size, fov)
        self.renderer = Renderer()

    @property
    def shot(self) -> CapturedScene:
        light = light_of(self.world.weather)
        return CapturedScene(static_scene_of(self.world.roads), cast(self.world, light), light, self.world.frame)

    def rgb(self):
        """(height, width, 3), red, green, blue."""
        return self.renderer.rgb(self.shot, self.view)[..., 2::-1].astype(int)

    def tags(self):
        return self.renderer.tags(self.shot, self.view)[..., 2]

    def ids(self):
        seen = self.renderer.instances(self.shot, self.view).astype(int)
        return seen[..., 1] + 256 * seen[..., 0]

    def depth(self):
        return self.renderer.depth(self.shot, self.view)

    def corners(self, actor):
        """An actor's box in the picture: u, v and distance of its eight corners."""
        box = actor.box
        signs = np.array([(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)])
        local = np.array(box.center) + signs * np.array(box.extent)
        matrix = matrix_of(self.world.pose(actor))
        return self.view.pixels(local @ matrix[:3, :3].T + matrix[:3, 3])

    def around(self, actor, x=0.0, y=0.0, z=0.0, half=3):
        """The part of the picture around a point of an actor's frame, as slices."""
        matrix = matrix_of(self.world.pose(actor))
        u, v, ahead = self.view.pixels((matrix[:3, :3] @ np.array([x, y, z]) + matrix[:3, 3])[None])[0]
        assert ahead > 0
        return slice(max(0, int(v) - half), int(v) + half + 1), slice(max(0, int(u) - half), int(u) + half + 1)
