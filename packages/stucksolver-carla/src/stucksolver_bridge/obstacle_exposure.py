"""Shows CARLA's own agents the obstacles that they do not look for: they ask only for vehicles and walkers."""

from __future__ import annotations

from typing import Any, Callable, Iterable, Iterator

from stucksolver_bridge.actor_boxes import ActorBoxes

LOW_M = 0.15
"""Lower objects can be driven over without harm; no car stops for dirt on the road."""
AROUND_M = 60.0
VEHICLES = "*vehicle*"


def props_around(world: Any, vehicle: Any) -> Callable[[], list[Any]]:
    """Return a source of perceived obstacles: stationary objects around a vehicle, from the client's ground truth."""
    bodies = ActorBoxes(world, vehicle.id)

    def look() -> list[Any]:
        place = vehicle.get_location()
        return [
            found.body.actor
            for found in bodies.near(place.x, place.y, AROUND_M)
            if found.body.actor.type_id.startswith("static.") and 2.0 * found.body.half_height_m >= LOW_M
        ]

    return look


class ObstacleExposingWorld:
    """Takes the place of an agent's `carla.World`: it lists the perceived obstacles among the vehicles, nearest first.

    The order matters, because `BasicAgent` takes the first hit in the list for the nearest one. With two cyclists in a
    row, it could otherwise follow the far one and run into the near one.

    `obstacles` returns objects with `id`, `type_id`, `bounding_box`, `get_transform`, `get_location`, `get_velocity`.
    """

    def __init__(self, world: Any, vehicle: Any, obstacles: Callable[[], Iterable[Any]]) -> None:
        self._shown = world
        self._vehicle = vehicle
        self._obstacles = obstacles

    def get_actors(self, *ids: Any) -> Any:
        """Return CARLA's list. Without ids, its vehicles include the obstacles that the agent should see."""
        actors = self._shown.get_actors(*ids)
        return actors if ids else ObstacleExposingActors(actors, self._vehicle, self._obstacles)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._shown, name)


class ObstacleExposingActors:
    """A `carla.ActorList` whose vehicles include the obstacles."""

    def __init__(self, actors: Any, vehicle: Any, obstacles: Callable[[], Iterable[Any]]) -> None:
        self._actors = actors
        self._vehicle = vehicle
        self._obstacles = obstacles

    def filter(self, pattern: str) -> Any:
        """Return what CARLA's filter finds; vehicles together with the obstacles, nearest first."""
        found = self._actors.filter(pattern)
        if pattern != VEHICLES:
            return found
        here = self._vehicle.get_location()
        return sorted([*found, *self._obstacles()], key=lambda thing: float(here.distance(thing.get_location())))

    def find(self, actor_id: int) -> Any:
        """Return an actor by its id; None if there is none."""
        return self._actors.find(actor_id)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._actors)

    def __len__(self) -> int:
        return len(self._actors)

    def __getitem__(self, index: int) -> Any:
        return self._actors[index]
