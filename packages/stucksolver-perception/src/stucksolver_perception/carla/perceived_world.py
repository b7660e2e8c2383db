"""The world as sensed: the part of `carla.World` that drivers and `CarlaSenses` use.

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

_SHOWS = {
    LightState.RED: carla.TrafficLightState.Red,
    LightState.YELLOW: carla.TrafficLightState.Yellow,
    LightState.GREEN: carla.TrafficLightState.Green,
    LightState.OFF: carla.TrafficLightState.Off,
    LightState.UNKNOWN: carla.TrafficLightState.Unknown,
}


class PerceivedWorld:
    """The world of one ego. With `heeds_unknown`, a light of unknown state is reported to the driver as red."""

    def __init__(self, world: carla.World, carla_map: carla.Map, eyes: EgoPerception) -> None:
        self._world, self._map, self._eyes = world, carla_map, eyes
        actors = world.get_actors()
        self._lights = [PerceivedLight(light, eyes) for light in actors.filter("*traffic_light*")]
        self._signs = list(actors.filter("*traffic.stop*"))

    def get_map(self) -> carla.Map:
        """The map."""
        return self._map

    def get_snapshot(self) -> Any:
        """Time and frame of this tick; it contains no actors."""
        return _Snapshot(self._world.get_snapshot())

    def get_actors(self, ids: Sequence[int] | None = None, /) -> Any:
        """Return tracked objects by id; without ids, the static objects of the map, to be filtered."""
        if ids is None:
            return SimpleNamespace(filter=self._standing)
        return self._eyes.actors(ids)

    def get_vehicles_light_states(self) -> dict[int, int]:
        """Lamps of tracked vehicles, as bits of `carla.VehicleLightState`."""
        return self._eyes.lamps()

    def _standing(self, pattern: str) -> list[Any]:
        kinds: dict[str, list[Any]] = {"traffic_light": [*self._lights], "traffic.stop": self._signs}
        return kinds.get(pattern.strip("*"), [])


class PerceivedLight:
    """A `carla.TrafficLight` whose position is known from the map and whose state comes from the camera."""

    def __init__(self, light: carla.TrafficLight, eyes: EgoPerception) -> None:
        self._light, self._eyes = light, eyes
        self.id = int(light.id)

    @property
    def state(self) -> Any:
        """The state that was seen; see `get_state`."""
        return self.get_state()

    def get_state(self) -> Any:
        """Return the `carla.TrafficLightState`; Unknown if the camera cannot tell."""
        return _SHOWS[self._eyes.light(self.id)]

    def get_stop_waypoints(self) -> Any:
        """Return the waypoints of its stop lines on the map."""
        return self._light.get_stop_waypoints()

    def get_transform(self) -> carla.Transform:
        """Return its transform."""
        return self._light.get_transform()

    @property
    def trigger_volume(self) -> carla.BoundingBox:
        """Its trigger volume."""
        return self._light.trigger_volume


class _Snapshot:
    """The counterpart of `carla.WorldSnapshot` for a world in which the client reports no actors."""

    def __init__(self, snapshot: carla.WorldSnapshot) -> None:
        self.frame = snapshot.frame
        self.timestamp = snapshot.timestamp

    def __iter__(self) -> Iterator[Any]:
        return iter(())

    def find(self, actor_id: int) -> None:
        """Return None: it contains no actors."""
