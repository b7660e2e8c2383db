"""Describes the perceived world with the part of `carla.World` that drivers and `CarlaSceneSource` use.

The map, with the lights' stop lines and the stop signs, is known in advance, like a high-definition map. Moving objects
and the states of lights come from the sensors.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import carla

from stucksolver.scene.surroundings import LightState

if TYPE_CHECKING:
    from stucksolver_perception.carla.ego_perception import EgoPerception

_CARLA_STATES = {
    LightState.RED: carla.TrafficLightState.Red,
    LightState.YELLOW: carla.TrafficLightState.Yellow,
    LightState.GREEN: carla.TrafficLightState.Green,
    LightState.OFF: carla.TrafficLightState.Off,
    LightState.UNKNOWN: carla.TrafficLightState.Unknown,
}


class PerceivedWorld:
    """The perceived world of one ego."""

    def __init__(self, world: carla.World, carla_map: carla.Map, perception: EgoPerception) -> None:
        self._world, self._map, self._perception = world, carla_map, perception
        actors = world.get_actors()
        self._lights = [PerceivedLight(light, perception) for light in actors.filter("*traffic_light*")]
        self._signs = list(actors.filter("*traffic.stop*"))

    def get_map(self) -> carla.Map:
        """Return the map."""
        return self._map

    def get_snapshot(self) -> Any:
        """Return a snapshot with time and frame of this tick, and without actors."""
        return _Snapshot(self._world.get_snapshot())

    def get_actors(self, ids: Sequence[int] | None = None, /) -> Any:
        """Return tracked objects by id; without ids, the static objects of the map, with a filter."""
        if ids is None:
            return SimpleNamespace(filter=self._static_actors)
        return self._perception.actors(ids)

    def get_vehicles_light_states(self) -> dict[int, int]:
        """Return the lamps of tracked vehicles, as bits of `carla.VehicleLightState`."""
        return self._perception.lamps()

    def _static_actors(self, pattern: str) -> list[Any]:
        kinds: dict[str, list[Any]] = {"traffic_light": [*self._lights], "traffic.stop": self._signs}
        return kinds.get(pattern.strip("*"), [])


class PerceivedLight:
    """A `carla.TrafficLight` with its position from the map and its state from the camera."""

    def __init__(self, light: carla.TrafficLight, perception: EgoPerception) -> None:
        self._light, self._perception = light, perception
        self.id = int(light.id)

    @property
    def state(self) -> Any:
        """The perceived state; see `get_state`."""
        return self.get_state()

    def get_state(self) -> Any:
        """Return the `carla.TrafficLightState`; Unknown without a certain one from the camera."""
        return _CARLA_STATES[self._perception.light(self.id)]

    def get_stop_waypoints(self) -> Any:
        """Return the waypoints of the light's stop lines on the map."""
        return self._light.get_stop_waypoints()

    def get_transform(self) -> carla.Transform:
        """Return the light's transform."""
        return self._light.get_transform()

    @property
    def trigger_volume(self) -> carla.BoundingBox:
        """The light's trigger volume."""
        return self._light.trigger_volume


class _Snapshot:
    """The counterpart of `carla.WorldSnapshot` for a world in which the client reports no actors."""

    def __init__(self, snapshot: carla.WorldSnapshot) -> None:
        self.frame = snapshot.frame
        self.timestamp = snapshot.timestamp

    def __iter__(self) -> Iterator[Any]:
        return iter(())

    def find(self, actor_id: int) -> None:
        """Return None, because the snapshot contains no actors."""
