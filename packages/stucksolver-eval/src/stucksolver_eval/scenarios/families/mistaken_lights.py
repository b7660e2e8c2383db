"""Traffic lights as a faulty perception sees them: a state that is wrong, or a light that does not exist.

Driver and solver read lights through the ego's world. `MistakenEgo` has a world in which some lights differ.
Criteria and other traffic use the real world.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import carla

PHANTOM_ID = 1_000_000_000
"""Actor id of a light that does not exist."""
STATES = {
    "red": carla.TrafficLightState.Red,
    "green": carla.TrafficLightState.Green,
    "off": carla.TrafficLightState.Off,
    "unknown": carla.TrafficLightState.Unknown,
}
Read = Callable[[], str]
"""Returns the perceived state: a key of `STATES`."""


class _Stand:
    """Delegates to a real object what is not replaced."""

    def __init__(self, real: Any) -> None:
        self._real = real

    def __getattr__(self, name: str) -> Any:
        return getattr(self._real, name)


class MistakenLight(_Stand):
    """A light whose state perception reports wrongly."""

    def __init__(self, real: Any, read: Read) -> None:
        super().__init__(real)
        self._read = read

    @property
    def state(self) -> carla.TrafficLightState:
        """The perceived state."""
        return STATES[self._read()]

    def get_state(self) -> carla.TrafficLightState:
        """Return the perceived state."""
        return self.state


class PhantomLight(MistakenLight):
    """A light that does not exist, with a stop line at a waypoint."""

    id = PHANTOM_ID

    def __init__(self, line: carla.Waypoint, read: Read) -> None:
        super().__init__(None, read)
        self._line = line

    def get_stop_waypoints(self) -> list[carla.Waypoint]:
        """Return the waypoint of the stop line."""
        return [self._line]


class _Actors(_Stand):
    """An actor list in which mistaken lights replace the real ones with the same id."""

    def __init__(self, real: Any, lights: Sequence[MistakenLight]) -> None:
        super().__init__(real)
        self._lights = {light.id: light for light in lights}

    def filter(self, pattern: str) -> list[Any]:
        """Return the actors of a type; with a pattern of traffic lights, phantoms too."""
        found = list(self._real.filter(pattern))
        if "traffic_light" not in pattern:
            return found
        phantoms = [light for light in self._lights.values() if isinstance(light, PhantomLight)]
        return [*(self._lights.get(actor.id, actor) for actor in found), *phantoms]


class _World(_Stand):
    def __init__(self, real: Any, lights: Sequence[MistakenLight]) -> None:
        super().__init__(real)
        self._lights = lights

    def get_actors(self, *ids: Any) -> Any:
        found = self._real.get_actors(*ids)
        return found if ids else _Actors(found, self._lights)

    def spawn_actor(self, *args: Any, attach_to: Any = None) -> Any:
        parent = attach_to._real if isinstance(attach_to, _Stand) else attach_to
        return self._real.spawn_actor(*args, attach_to=parent)


class MistakenEgo(_Stand):
    """The ego with mistaken lights in its world."""

    def __init__(self, real: Any, lights: Sequence[MistakenLight]) -> None:
        super().__init__(real)
        self._lights = lights

    def get_world(self) -> Any:
        """Return the world as perceived."""
        return _World(self._real.get_world(), self._lights)
