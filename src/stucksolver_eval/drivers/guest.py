"""An agent of the user's as a driver: it drives the route, and ours drives the paths of recovery plans."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from stucksolver.stacks.driver import BehaviorDriver, DrivePoint, RoutePoint
from stucksolver_eval.drivers.agent import Agent, checked


class GuestDriver:
    """See `Driver`. `helper` keeps the route, and drives while the agent is told to follow a path or to hold.

    An agent knows nothing of paths that others have planned, so it is not asked for a control meanwhile.
    """

    def __init__(self, agent: Agent, name: str, helper: BehaviorDriver) -> None:
        self._agent, self._name, self._helper = agent, name, helper
        self._told = False
        """Is a path followed, or a stop held?"""

    @property
    def route(self) -> Sequence[RoutePoint]:
        """The route that the agent was given."""
        return self._helper.route

    @property
    def path_left_m(self) -> float:
        """What is left of a plan's path (m)."""
        return self._helper.path_left_m

    @property
    def acceleration_mps2(self) -> float:
        """Of whoever drives the paths."""
        return self._helper.acceleration_mps2

    def set_destination(self, destination: Any, start: Any | None = None) -> None:
        """Traces a route and gives it to the agent."""
        self._helper.set_destination(destination, start)
        self._agent.set_route(self._helper.route)

    def set_route(self, route: Sequence[RoutePoint]) -> None:
        """Drive a route planned elsewhere."""
        self._helper.set_route(route)
        self._agent.set_route(self._helper.route)

    def run_step(self) -> Any:
        """The agent's control; while a plan is driven, that of our own controller."""
        if self._told:
            return self._helper.run_step()
        self._helper.keep_up()
        return checked(self._agent.run_step(), self._name)

    def done(self) -> bool:
        """Whether the route is driven."""
        return self._helper.done()

    def follow(self, path: Sequence[DrivePoint], reverse: bool = False, ignore: Collection[int] = frozenset()) -> None:
        """Drives a plan's path; the agent is not asked until `release`."""
        self._helper.follow(path, reverse, ignore)
        self._told = True

    def hold(self, brake_mps2: float | None = None) -> None:
        """Stops and stands until `release`."""
        self._helper.hold(brake_mps2)
        self._told = True

    def release(self) -> None:
        """Gives the vehicle back to the agent."""
        self._helper.release()
        self._told = False

    def close(self) -> None:
        """The drive is over."""
        close = getattr(self._agent, "close", None)
        if close is not None:
            close()
