"""The visible part of a world: its static scene, built once for each map, and its actors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from threading import Lock
from weakref import WeakKeyDictionary

import numpy as np

from carlette.camera.arrays import Bytes, Singles
from carlette.camera.environment.static_scene import StaticScene, build_static_scene
from carlette.camera.rendering.actor_parts import cast, contains
from carlette.camera.rendering.lighting import Light, light_of
from carlette.camera.rendering.renderer import CapturedScene, Renderer, RenderPart
from carlette.camera.rendering.view import FAR_M
from carlette.geometry import Vector
from carlette.opendrive.road_network import RoadNetwork
from carlette.world.actor import Actor
from carlette.world.world import World


@dataclass(frozen=True)
class CapturedActors:
    """The moving objects at one time. With the map's static scene, they are a `CapturedScene`."""

    roads: RoadNetwork
    parts: list[RenderPart]
    light: Light
    frame: int

    def from_inside(self, world: World, carrier: Actor | None, eye: Vector) -> CapturedActors:
        """Return the view without the carrier if the camera is inside its body, except for the light that it casts."""
        if carrier is None or not contains(world, carrier, eye):
            return self
        parts = [part for part in self.parts if part.actor_id != carrier.id or part.adds]
        return replace(self, parts=parts)

    def shot(self) -> CapturedScene:
        """Wait until the static scene is built."""
        return CapturedScene(static_scene_of(self.roads), self.parts, self.light, self.frame)


def notice(world: World) -> CapturedActors:
    """Capture the visible state of the actors. After that the world may continue."""
    light = light_of(world.weather)
    return CapturedActors(world.roads, cast(world, light), light, world.frame)


def take(world: World) -> CapturedScene:
    """Return all visible objects of a world at this time."""
    return notice(world).shot()


def static_scene_of(roads: RoadNetwork) -> StaticScene:
    """Return the static scene of a map. It is built once, on first use by any thread."""
    with _building:
        static_scene = _static_scenes.get(roads)
        if static_scene is None:
            static_scene = _static_scenes[roads] = build_static_scene(roads)
        return static_scene


@lru_cache(maxsize=1)
def the_renderer() -> Renderer:
    """Return the renderer of this process, so that cameras share its buffers and lit colors."""
    return Renderer()


def encode_depth(meters: Singles) -> Bytes:
    """Encode depths (m) as CARLA does: (R + 256 G + 65536 B) / (2^24 - 1) is the share of 1000 m; bytes B G R A."""
    value = (np.clip(meters / FAR_M, 0.0, 1.0).astype(np.float64) * 0xFFFFFF + 0.5).astype(np.uint32)
    packed = value >> 16 | value & 0xFF00 | (value & 0xFF) << 16 | np.uint32(0xFF000000)
    coded: Bytes = packed.astype(np.uint32).view(np.uint8).reshape(*meters.shape, 4)
    return coded


_building = Lock()
_static_scenes: WeakKeyDictionary[RoadNetwork, StaticScene] = WeakKeyDictionary()
