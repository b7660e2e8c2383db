"""Worlds in this process, without a server or client: for search, training and tests.

This module is the interface; the modules behind it may change. Units and frames are CARLA's: meters, seconds, degrees,
its left-handed world frame. `World.tick()` is one step. `World.fork()` returns an independent copy within a few
milliseconds (the map is shared). `World.traffic` drives some of the cars and is forked too.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from pathlib import Path

from carlette.errors import SpawnCollisionError
from carlette.geometry import Pose, Rotation, Vector
from carlette.opendrive.map_file import find_map, map_folders
from carlette.traffic import Traffic
from carlette.world.actor import Actor
from carlette.world.map_trial import open_roads
from carlette.world.spawn import spawn
from carlette.world.world import World

__all__ = [
    "Actor",
    "Pose",
    "Rotation",
    "SpawnCollisionError",
    "Traffic",
    "Vector",
    "World",
    "open_world",
    "populate",
    "spawn",
]

CAR = "vehicle.tesla.model3"


def open_world(town: str, folders: Sequence[str | Path] = (), seed: int = 0) -> World:
    """Open a town without actors.

    Args:
        town: Its name or its `.xodr` file.
        folders: Further folders, searched first.
        seed: Seed of all random choices, such as the lights' first phases.

    Raises:
        MapError: There is no such town, or its file cannot be used.
    """
    return World(open_roads(find_map(town, map_folders([str(folder) for folder in folders]))), seed)


def populate(world: World, cars: int, seed: int = 0, model: str = CAR) -> list[Actor]:
    """Put `cars` stationary cars at spawn points drawn with `seed`. There are fewer if there is not enough space."""
    spots = world.roads.spawn_points()
    random.Random(seed).shuffle(spots)
    found: list[Actor] = []
    for spot in spots:
        if len(found) == cars:
            break
        try:
            found.append(spawn(world, model, {}, spot))
        except SpawnCollisionError:
            # The spawn point is occupied; the loop tries the next one.
            continue
    return found
