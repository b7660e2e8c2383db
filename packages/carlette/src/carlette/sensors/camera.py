"""The four cameras as sensors: what their attributes mean, and what they send.

What is visible is captured on the tick; the pictures are drawn by a separate thread.
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
NARROWEST_DEG = 1.0
WIDEST_DEG = 170.0
_HEADER = struct.Struct("<IIf")


class Camera(LateSensor):
    """A camera. Only `image_size_x`, `image_size_y` and `fov` matter; lens, exposure and color have no effect."""

    def __init__(self, settings: SensorAttributes) -> None:
        super().__init__(settings)
        self.width = settings.whole("image_size_x", 1, LARGEST_PX)
        self.height = settings.whole("image_size_y", 1, LARGEST_PX)
        self.fov_deg = settings.number("fov", NARROWEST_DEG, WIDEST_DEG)

    def load(self, world: World) -> Future[None]:
        return build_static_scene(world.roads)

    def begin(self, moment: SensorTick) -> Future[list[Body]]:
        world = moment.scene.world
        seen = capture(moment.scene).from_inside(world, world.actors.get(moment.actor.parent_id), moment.pose.location)
        view = CameraView(moment.pose, self.width, self.height, self.fov_deg)
        return drawer().submit(lambda: self._drawn(seen, view))

    def _drawn(self, seen: CapturedActors, view: CameraView) -> list[Body]:
        picture = self.draw(the_renderer(), seen.shot(), view)
        return [(_HEADER.pack(self.width, self.height, self.fov_deg), picture.data.cast("B"))]

    @staticmethod
    @abstractmethod
    def draw(renderer: Renderer, shot: CapturedScene, view: CameraView) -> Bytes:
        """The picture: (height, width, 4) uint8, bytes B G R A, contiguous."""


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
    """The tag of what is seen, in red."""

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
    """Return what all cameras see on one tick; computed once."""
    seen = _seen.get(scene)
    if seen is None:
        seen = _seen[scene] = notice(scene.world)
    return seen


_seen: WeakKeyDictionary[SensorScene, CapturedActors] = WeakKeyDictionary()
