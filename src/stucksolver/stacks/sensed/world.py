"""The world as sensed: what drivers and `CarlaSenses` ask of a `carla.World`.

The map, with lights' stop lines and stop signs on it, is known beforehand, as a high-definition map is. What moves, and
what a light shows, is what the sensors saw.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import carla

from stucksolver.scene.surroundings import LightState

if TYPE_CHECKING:
    from stucksolver.stacks.sensed.eyes import Eyes

_SHOWS = {
    LightState.RED: carla.TrafficLightState.Red,
    LightState.YELLOW: carla.TrafficLightState.Yellow,
    LightState.GREEN: carla.TrafficLightState.Green,
    LightState.OFF: carla.TrafficLightState.Off,
    LightState.UNKNOWN: carla.TrafficLightState.Unknown,
}


class SensedWorld:
    """Of one ego. `heeds_unknown`: a light whose state is not known is given to the driver as red, never as green."""

    def __init__(self, world: carla.World, carla_map: carla.Map, eyes: Eyes) -> None:
        self._world, self._map, self._eyes = world, carla_map, eyes
        actors = world.get_actors()
        self._lights = [SensedLight(light, eyes) for light in actors.filter("*traffic_light*")]
        self._signs = list(actors.filter("*traffic.stop*"))

    def get_map(self) -> carla.Map:
        """The map."""
        return self._map

    def get_snapshot(self) -> Any:
        """Time and frame of this tick; nobody is in it."""
        return _Snapshot(self._world.get_snapshot())

    def get_actors(self, ids: Sequence[int] | None = None, /) -> Any:
        """Tracked objects by their ids; without ids, what stands on the map, to filter."""
        if ids is None:
            return SimpleNamespace(filter=self._standing)
        return self._eyes.actors(ids)

    def get_vehicles_light_states(self) -> dict[int, int]:
        """Lamps of tracked vehicles, as bits of `carla.VehicleLightState`."""
        return self._eyes.lamps()

    def _standing(self, pattern: str) -> list[Any]:
        kinds: dict[str, list[Any]] = {"traffic_light": [*self._lights], "traffic.stop": self._signs}
        return kinds.get(pattern.strip("*"), [])


class SensedLight:
    """A `carla.TrafficLight` whose place is known from the map, and whose state from the camera."""

    def __init__(self, light: carla.TrafficLight, eyes: Eyes) -> None:
        self._light, self._eyes = light, eyes
        self.id = int(light.id)

    @property
    def state(self) -> Any:
        """What it was seen to show; see `get_state`."""
        return self.get_state()

    def get_state(self) -> Any:
        """`carla.TrafficLightState`; Unknown where the camera cannot tell."""
        return _SHOWS[self._eyes.light(self.id)]

    def get_stop_waypoints(self) -> Any:
        """Its stop lines on the map."""
        return self._light.get_stop_waypoints()

    def get_transform(self) -> carla.Transform:
        """Where it stands."""
        return self._light.get_transform()

    @property
    def trigger_volume(self) -> carla.BoundingBox:
        """Where it applies."""
        return self._light.trigger_volume


class _Snapshot:
    """As `carla.WorldSnapshot`, of a world in which the client tells of nobody."""

    def __init__(self, snapshot: carla.WorldSnapshot) -> None:
        self.frame = snapshot.frame
        self.timestamp = snapshot.timestamp

    def __iter__(self) -> Iterator[Any]:
        return iter(())

    def find(self, actor_id: int) -> None:
        """Nobody is found in it."""
