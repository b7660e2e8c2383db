"""What the evaluation asks of a driver, and the little that it asks of an agent of the user's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

from stucksolver.stacks.driver import Driver, RoutePoint

if TYPE_CHECKING:
    import carla


class AgentError(RuntimeError):
    """An agent of the user's did what no agent may; the message names it, what it did and what is asked for."""


class Agent(Protocol):
    """An agent that drives a route, made as `Class(vehicle, carla_map)` once the ego stands at the route's start.

    With `MODULE:CLASS@FILE` it is made as `Class(vehicle, carla_map, FILE)`, the file's name as it was given.
    A method `close()` is called at the end, where there is one.
    """

    def set_route(self, route: Sequence[RoutePoint]) -> None:
        """Before the first step, and whenever the route is planned anew: a point about each metre."""

    def run_step(self) -> Any:
        """This tick's `carla.VehicleControl`, not applied. Not called while a recovery plan is driven."""


class RouteDriver(Driver, Protocol):
    """A driver that takes a route, and tells how much is left of a path."""

    @property
    def path_left_m(self) -> float:
        """Length of the line being driven that is still ahead."""

    def set_route(self, route: Sequence[RoutePoint]) -> None:
        """Drive a route planned elsewhere."""


def checked(control: carla.VehicleControl, who: str) -> Any:
    """A control that can be applied. Raises `AgentError`."""
    values = {part: getattr(control, part, None) for part in ("throttle", "steer", "brake")}
    if all(isinstance(value, int | float) and math.isfinite(value) for value in values.values()):
        return control
    given = ", ".join(f"{part} {value}" for part, value in values.items())
    raise AgentError(
        f"{who}.run_step gave a {type(control).__name__} with {given}: "
        "it must give a carla.VehicleControl with finite throttle, steer and brake"
    )
