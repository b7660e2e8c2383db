"""The interfaces of a driver and of a user's agent in an evaluation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

from stucksolver_carla.drivers.behavior import Driver, RoutePoint

if TYPE_CHECKING:
    import carla


class AgentError(RuntimeError):
    """A user's agent violated its interface. The message names the agent, the violation and the requirement."""


class Agent(Protocol):
    """An agent that drives a route. It is created as `Class(vehicle, carla_map)` with the ego at the route's start.

    With `MODULE:CLASS@FILE` it is created as `Class(vehicle, carla_map, FILE)`, with the file name unchanged. A method
    `close()`, if it exists, is called at the end.
    """

    def set_route(self, route: Sequence[RoutePoint]) -> None:
        """Set a route of about one point per meter.

        Called before the first step and after every change of the route.
        """

    def run_step(self) -> Any:
        """Return this tick's `carla.VehicleControl` without applying it. Not called while a recovery plan runs."""


class RouteDriver(Driver, Protocol):
    """A driver that accepts a route, and reports the remaining length of its path."""

    @property
    def path_left_m(self) -> float:
        """Remaining length of the current path (m)."""

    def set_route(self, route: Sequence[RoutePoint]) -> None:
        """Drive this route."""


def checked(control: carla.VehicleControl, name: str) -> Any:
    """Return the control if its values are finite numbers. Raises `AgentError`, which names `name`."""
    values = {part: getattr(control, part, None) for part in ("throttle", "steer", "brake")}
    if all(isinstance(value, int | float) and math.isfinite(value) for value in values.values()):
        return control
    values_text = ", ".join(f"{part} {value}" for part, value in values.items())
    raise AgentError(
        f"{name}.run_step returned a {type(control).__name__} with {values_text}: "
        "it must return a carla.VehicleControl with finite throttle, steer and brake"
    )
