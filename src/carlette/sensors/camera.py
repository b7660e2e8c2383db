"""The four cameras as sensors: what their attributes mean, and what they send.

Pictures of one tick are drawn one after the other by one thread beside the server's, while it does other work; the
rasteriser lets go of Python's lock.
"""

from __future__ import annotations

import struct
from abc import abstractmethod
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from functools import lru_cache
from typing import ClassVar
from weakref import WeakKeyDictionary

from carlette.camera.painter import Painter, Shot
from carlette.camera.raster import Bytes, the_raster
from carlette.camera.studio import encode_depth, take, the_painter, without_carrier
from carlette.camera.view import View
from carlette.errors import RequestError, UsageError
from carlette.sensors.base import Body, Moment, Sensor, Settings
from carlette.sensors.scene import Scene

LARGEST_PX = 4096
NARROWEST_DEG, WIDEST_DEG = 1.0, 170.0
_HEADER = struct.Struct("<IIf")


class Camera(Sensor):
    """A camera: `image_size_x`, `image_size_y` and `fov` count; lens, exposure and colour attributes have no effect."""

    is_ready_later: ClassVar[bool] = True

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings)
        self.width = settings.whole("image_size_x", 1, LARGEST_PX)
        self.height = settings.whole("image_size_y", 1, LARGEST_PX)
        self.fov_deg = settings.number("fov", NARROWEST_DEG, WIDEST_DEG)
        try:
            the_raster()
        except UsageError as error:
            raise RequestError(f"Spawn of '{settings.type_id}' refused: {error}") from None
        self._picture: Future[Bytes] | None = None

    def prepare(self, moment: Moment) -> None:
        world, eye = moment.scene.world, moment.pose.location
        shot = without_carrier(shot_of(moment.scene), world, world.actors.get(moment.actor.parent_id), eye)
        view = View(moment.pose, self.width, self.height, self.fov_deg)
        self._picture = _artist().submit(self.draw, the_painter(), shot, view)

    def measure(self, moment: Moment) -> Iterator[Body]:
        if self._picture is None:
            self.prepare(moment)
        assert self._picture is not None
        picture = self._picture.result()
        self._picture = None
        yield _HEADER.pack(self.width, self.height, self.fov_deg), picture.data.cast("B")

    @staticmethod
    @abstractmethod
    def draw(painter: Painter, shot: Shot, view: View) -> Bytes:
        """The picture: (height, width, 4) uint8, bytes B G R A, contiguous."""


class ColorCamera(Camera):
    """What the eye would see."""

    wire_type: ClassVar[int] = 13

    @staticmethod
    def draw(painter: Painter, shot: Shot, view: View) -> Bytes:
        return painter.rgb(shot, view)


class DepthCamera(Camera):
    """Distances ahead of the camera's plane, up to 1000 m, as 24-bit numbers."""

    wire_type: ClassVar[int] = 1

    @staticmethod
    def draw(painter: Painter, shot: Shot, view: View) -> Bytes:
        return encode_depth(painter.depth(shot, view))


class SemanticCamera(Camera):
    """The tag of what is seen, in red."""

    wire_type: ClassVar[int] = 14

    @staticmethod
    def draw(painter: Painter, shot: Shot, view: View) -> Bytes:
        return painter.tags(shot, view)


class InstanceCamera(Camera):
    """The tag in red, the actor's id in green and blue."""

    wire_type: ClassVar[int] = 15

    @staticmethod
    def draw(painter: Painter, shot: Shot, view: View) -> Bytes:
        return painter.instances(shot, view)


def shot_of(scene: Scene) -> Shot:
    """What all cameras of one tick look at; worked out once."""
    shot = _shots.get(scene)
    if shot is None:
        shot = _shots[scene] = take(scene.world)
    return shot


@lru_cache(maxsize=1)
def _artist() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(1, "carlette-camera")


_shots: WeakKeyDictionary[Scene, Shot] = WeakKeyDictionary()
