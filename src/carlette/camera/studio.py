"""What cameras look at, worked out of a world: its static scene, built once for each map, and its actors."""

from __future__ import annotations

from functools import lru_cache
from weakref import WeakKeyDictionary

import numpy as np

from carlette.camera.cast import cast, contains
from carlette.camera.light import light_of
from carlette.camera.painter import Painter, Shot
from carlette.camera.raster import Bytes, Singles
from carlette.camera.stage import Stage, build_stage
from carlette.camera.view import FAR_M
from carlette.geometry import Vector
from carlette.opendrive.roads import RoadNetwork
from carlette.world.actor import Actor
from carlette.world.world import World


def take(world: World) -> Shot:
    """Everything to be seen in a world at this moment."""
    light = light_of(world.weather)
    return Shot(stage_of(world.roads), cast(world, light), light, world.frame)


def without_carrier(shot: Shot, world: World, carrier: Actor | None, eye: Vector) -> Shot:
    """A camera inside its carrier's body does not see that from within."""
    if carrier is None or not contains(world, carrier, eye):
        return shot
    parts = [one for one in shot.parts if one.actor_id != carrier.id or one.is_shade]
    return Shot(shot.stage, parts, shot.light, shot.frame)


def stage_of(roads: RoadNetwork) -> Stage:
    """The static scene of a map; built when it is first seen, shared by all cameras."""
    stage = _stages.get(roads)
    if stage is None:
        stage = _stages[roads] = build_stage(roads)
    return stage


@lru_cache(maxsize=1)
def the_painter() -> Painter:
    """The painter of this process: there is one rasteriser."""
    return Painter()


def encode_depth(metres: Singles) -> Bytes:
    """CARLA's coding: (R + 256 G + 65536 B) / (2^24 - 1) is the share of 1000 m; bytes B G R A."""
    value = (np.clip(metres / FAR_M, 0.0, 1.0).astype(np.float64) * 0xFFFFFF + 0.5).astype(np.uint32)
    packed = value >> 16 | value & 0xFF00 | (value & 0xFF) << 16 | np.uint32(0xFF000000)
    coded: Bytes = packed.astype(np.uint32).view(np.uint8).reshape(*metres.shape, 4)
    return coded


_stages: WeakKeyDictionary[RoadNetwork, Stage] = WeakKeyDictionary()
