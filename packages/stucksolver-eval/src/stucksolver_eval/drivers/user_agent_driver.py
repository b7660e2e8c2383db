"""A user's agent as a driver: the agent drives the route, and a built-in driver follows the paths of recovery plans."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from stucksolver_carla.drivers.behavior import BehaviorDriver, DrivePoint, RoutePoint
from stucksolver_eval.drivers.agent import Agent, checked


class UserAgentDriver:
    """Implements `RouteDriver`. `helper` stores the route, and drives while a path is followed or the vehicle is held.

    The agent cannot follow the paths of other planners, so its `run_step` is not called in the meantime.
    """

    def __init__(self, agent: Agent, name: str, helper: BehaviorDriver) -> None:
        self._agent, self._name, self._helper = agent, name, helper
        self._is_helper_driving = False
        """True while the helper follows a path or holds the vehicle."""

    @property
    def route(self) -> Sequence[RoutePoint]:
        """The agent's route."""
        return self._helper.route

    @property
    def path_left_m(self) -> float:
        """Remaining length of a plan's path (m)."""
        return self._helper.path_left_m

    @property
    def acceleration_mps2(self) -> float:
        """Acceleration of the driver that follows the paths (m/s²)."""
        return self._helper.acceleration_mps2

    def set_destination(self, destination: Any, start: Any | None = None) -> None:
        """Plan a route and pass it to the agent."""
        self._helper.set_destination(destination, start)
        self._agent.set_route(self._helper.route)

    def set_route(self, route: Sequence[RoutePoint]) -> None:
        """Drive this route."""
        self._helper.set_route(route)
        self._agent.set_route(self._helper.route)

    def run_step(self) -> Any:
        """Return the agent's control, or the helper's while a plan runs. Raises `AgentError`."""
        if self._is_helper_driving:
            return self._helper.run_step()
        self._helper.keep_up()
        return checked(self._agent.run_step(), self._name)

    def done(self) -> bool:
        """Return True if the route is completed."""
        return self._helper.done()

    def follow(self, path: Sequence[DrivePoint], reverse: bool = False, ignore: Collection[int] = frozenset()) -> None:
        """Follow a plan's path. The agent does not drive until `release`."""
        self._helper.follow(path, reverse, ignore)
        self._is_helper_driving = True

    def hold(self, brake_mps2: float | None = None) -> None:
        """Stop and stay stopped until `release`."""
        self._helper.hold(brake_mps2)
        self._is_helper_driving = True

    def release(self) -> None:
        """Return control to the agent."""
        self._helper.release()
        self._is_helper_driving = False

    def close(self) -> None:
        """Close the agent, if it has a method `close`."""
        close = getattr(self._agent, "close", None)
        if close is not None:
            close()
