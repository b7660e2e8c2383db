"""Adds obstacles to the actors that CARLA's agents read: the agents request only vehicles and walkers."""

from __future__ import annotations

from typing import Any, Callable, Iterable, Iterator

from stucksolver_bridge.actor_boxes import ActorBoxes

LOW_M = 0.15
"""Minimum height of an obstacle (m). Lower objects can be driven over without harm. Ours."""
RANGE_M = 60.0
"""Half size of the square around the ego from which obstacles are taken (m). Ours."""
VEHICLES = "*vehicle*"
"""The filter pattern with which `BasicAgent` requests vehicles."""


def props_around(world: Any, vehicle: Any) -> Callable[[], list[Any]]:
    """Return a callable that returns the static objects around a vehicle, from the client's ground truth."""
    bodies = ActorBoxes(world, vehicle.id)

    def stationary_objects() -> list[Any]:
        location = vehicle.get_location()
        return [
            found.body.actor
            for found in bodies.near(location.x, location.y, RANGE_M)
            if found.body.actor.type_id.startswith("static.") and 2.0 * found.body.half_height_m >= LOW_M
        ]

    return stationary_objects


class ObstacleExposingWorld:
    """A replacement for an agent's `carla.World` that lists the obstacles among the vehicles, nearest first.

    The order matters, because `BasicAgent` treats the first hit in the list as the nearest one. With two cyclists in a
    row, it could otherwise follow the far one and collide with the near one.

    `obstacles` returns objects with `id`, `type_id`, `bounding_box`, `get_transform`, `get_location`, `get_velocity`.
    """

    def __init__(self, world: Any, vehicle: Any, obstacles: Callable[[], Iterable[Any]]) -> None:
        self._world = world
        self._vehicle = vehicle
        self._obstacles = obstacles

    def get_actors(self, *ids: Any) -> Any:
        """Return CARLA's list. Without `ids`, its vehicles include the obstacles."""
        actors = self._world.get_actors(*ids)
        return actors if ids else ObstacleExposingActors(actors, self._vehicle, self._obstacles)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._world, name)


class ObstacleExposingActors:
    """A `carla.ActorList` whose vehicles include the obstacles."""

    def __init__(self, actors: Any, vehicle: Any, obstacles: Callable[[], Iterable[Any]]) -> None:
        self._actors = actors
        self._vehicle = vehicle
        self._obstacles = obstacles

    def filter(self, pattern: str) -> Any:
        """Return the result of CARLA's filter. Vehicles are returned together with the obstacles, nearest first."""
        actors = self._actors.filter(pattern)
        if pattern != VEHICLES:
            return actors
        here = self._vehicle.get_location()
        return sorted([*actors, *self._obstacles()], key=lambda actor: float(here.distance(actor.get_location())))

    def find(self, actor_id: int) -> Any:
        """Return the actor with this id; None if it does not exist."""
        return self._actors.find(actor_id)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._actors)

    def __len__(self) -> int:
        return len(self._actors)

    def __getitem__(self, index: int) -> Any:
        return self._actors[index]
