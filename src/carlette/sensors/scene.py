"""The world as sensors see it: what several of them need in one tick is worked out once."""

from __future__ import annotations

from carlette.world.world import World


class Scene:
    """One frame of one world; made anew for each tick in which a sensor is due."""

    def __init__(self, world: World) -> None:
        self.world = world
