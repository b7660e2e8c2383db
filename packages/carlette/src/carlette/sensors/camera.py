"""The four cameras as sensors: the meaning of their attributes, and their messages.

The visible state is captured on the tick. A separate thread draws the pictures.
"""

from __future__ import annotations

import struct
from abc import abstractmethod
from concurrent.futures import Future
from typing import ClassVar
from weakref import WeakKeyDictionary

from carlette.camera.arrays import Bytes
from carlette.camera.rendering.renderer import CapturedScene, Renderer
from carlette.camera.rendering.scene_capture import CapturedActors, encode_depth, notice, the_renderer
from carlette.camera.rendering.view import CameraView
from carlette.sensors.sensor import Body, LateSensor, SensorAttributes, SensorTick
from carlette.sensors.sensor_scene import SensorScene
from carlette.sensors.workers import build_static_scene, drawer
from carlette.world.world import World

LARGEST_PX = 4096
"""Largest width and height of a picture (px). Ours."""
NARROWEST_DEG = 1.0
"""Smallest field of view (degrees). Ours."""
WIDEST_DEG = 170.0
"""Largest field of view (degrees). Ours."""
_HEADER = struct.Struct("<IIf")


class Camera(LateSensor):
    """A camera. Only `image_size_x`, `image_size_y` and `fov` have an effect; lens, exposure and color have none."""

    def __init__(self, settings: SensorAttributes) -> None:
        super().__init__(settings)
        self.width = settings.whole("image_size_x", 1, LARGEST_PX)
        self.height = settings.whole("image_size_y", 1, LARGEST_PX)
        self.fov_deg = settings.number("fov", NARROWEST_DEG, WIDEST_DEG)

    def load(self, world: World) -> Future[None]:
        return build_static_scene(world.roads)

    def begin(self, moment: SensorTick) -> Future[list[Body]]:
        world = moment.scene.world
        captured = capture(moment.scene).from_inside(
            world, world.actors.get(moment.actor.parent_id), moment.pose.location
        )
        view = CameraView(moment.pose, self.width, self.height, self.fov_deg)
        return drawer().submit(lambda: self._drawn(captured, view))

    def _drawn(self, captured: CapturedActors, view: CameraView) -> list[Body]:
        picture = self.draw(the_renderer(), captured.shot(), view)
        return [(_HEADER.pack(self.width, self.height, self.fov_deg), picture.data.cast("B"))]

    @staticmethod
    @abstractmethod
    def draw(renderer: Renderer, shot: CapturedScene, view: CameraView) -> Bytes:
        """Return the picture: (height, width, 4) uint8, bytes B G R A, contiguous."""


class ColorCamera(Camera):
    """A color picture."""

    wire_type: ClassVar[int] = 13

    @staticmethod
    def draw(renderer: Renderer, shot: CapturedScene, view: CameraView) -> Bytes:
        return renderer.rgb(shot, view)


class DepthCamera(Camera):
    """Distances ahead of the camera's plane, up to 1000 m, as 24-bit numbers."""

    wire_type: ClassVar[int] = 1

    @staticmethod
    def draw(renderer: Renderer, shot: CapturedScene, view: CameraView) -> Bytes:
        return encode_depth(renderer.depth(shot, view))


class SemanticCamera(Camera):
    """The tag of the visible surface, in red."""

    wire_type: ClassVar[int] = 14

    @staticmethod
    def draw(renderer: Renderer, shot: CapturedScene, view: CameraView) -> Bytes:
        return renderer.tags(shot, view)


class InstanceCamera(Camera):
    """The tag in red, the actor's id in green and blue."""

    wire_type: ClassVar[int] = 15

    @staticmethod
    def draw(renderer: Renderer, shot: CapturedScene, view: CameraView) -> Bytes:
        return renderer.instances(shot, view)


def capture(scene: SensorScene) -> CapturedActors:
    """Return the visible state of one tick for all cameras. It is computed once."""
    captured = _captured.get(scene)
    if captured is None:
        captured = _captured[scene] = notice(scene.world)
    return captured


_captured: WeakKeyDictionary[SensorScene, CapturedActors] = WeakKeyDictionary()
