"""Defines the interface that a driver must have to be used with the solver, in CARLA's terms."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

if TYPE_CHECKING:
    import carla


class DrivePoint(NamedTuple):
    """One point of a path, in CARLA's left-handed world frame (x east, y south, meters)."""

    x_m: float
    y_m: float
    speed_mps: float
    """Upper bound of the speed at this point (m/s)."""


class RoutePoint(NamedTuple):
    """One point of the planned route; points are about a meter apart."""

    waypoint: carla.Waypoint
    """`carla.Waypoint` at the center of the route's lane."""
    command: str
    """`lane_follow`, `left`, `right`, `straight`, `change_left` or `change_right`."""


class RouteHolder(Protocol):
    """Provides the ego's route."""

    @property
    def route(self) -> Sequence[RoutePoint]:
        """The whole planned route, including the points behind the ego."""


class PathFollower(Protocol):
    """Controllers that drive the ego along its route or along a path."""

    def run_step(self) -> Any:
        """Return this tick's `carla.VehicleControl`, not applied."""

    def follow(self, path: Sequence[DrivePoint], reverse: bool = False, ignore: Collection[int] = frozenset()) -> None:
        """Drive `path` instead of the route from the next step on, and brake for obstacles in it.

        Args:
            path: Points in CARLA's world frame.
            reverse: True to back up along the path, which leads away behind the ego.
            ignore: Ids of actors that do not count as obstacles.
        """

    def hold(self, brake_mps2: float | None = None) -> None:
        """Brake to a stop and stay stopped from the next step on.

        `brake_mps2` is the deceleration (m/s²); None brakes as gently as usual.
        """

    def release(self) -> None:
        """End `follow` or `hold`, and drive the route again from its nearest point ahead."""


class Driver(RouteHolder, PathFollower, Protocol):
    """A planner with controllers that drives the ego along a route or along a path."""

    def set_destination(self, destination: carla.Location, start: carla.Location | None = None) -> None:
        """Plan a route to `destination`.

        Args:
            destination: The destination.
            start: The start; the ego's own location if None.

        Raises:
            RouteError: There is no route.
        """

    def done(self) -> bool:
        """Return True if the ego is at the end of its route."""
