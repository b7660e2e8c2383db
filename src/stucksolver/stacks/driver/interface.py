"""What a driving stack must offer to be helped out of immobilization: one small interface, in CARLA terms."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

if TYPE_CHECKING:
    import carla


class DrivePoint(NamedTuple):
    """One point of a path to drive, in CARLA's left-handed world frame (x east, y south, metres)."""

    x_m: float
    y_m: float
    speed_mps: float
    """Upper bound on the speed at this point."""


class RoutePoint(NamedTuple):
    """One point of the planned route, spaced about a metre apart."""

    waypoint: carla.Waypoint
    """`carla.Waypoint` at the centre of the lane the route follows."""
    command: str
    """`lane_follow`, `left`, `right`, `straight`, `change_left` or `change_right`."""


class HasRoute(Protocol):
    """Knows the way that the ego takes."""

    @property
    def route(self) -> Sequence[RoutePoint]:
        """The whole planned route, points already passed included."""


class DrivesPath(Protocol):
    """Has controllers that drive the ego, on its way or on a path that it is given."""

    def run_step(self) -> Any:
        """Decide this tick's `carla.VehicleControl`; does not apply it."""

    def follow(self, path: Sequence[DrivePoint], reverse: bool = False, ignore: Collection[int] = frozenset()) -> None:
        """Drive `path` in place of the route from the next step on, still braking for what lies in it.

        With `reverse` the ego backs up along it: the path leads away behind the ego. Actors whose ids are in `ignore`
        are driven over.
        """

    def hold(self, brake_mps2: float | None = None) -> None:
        """Brake to a stop and stay stopped from the next step on; this hard, or as gently as usual where None."""

    def release(self) -> None:
        """End `follow` or `hold`: drive the route again, from the nearest point of it that lies ahead."""


class Driver(HasRoute, DrivesPath, Protocol):
    """A planner with controllers, as a stack has one: it drives the ego along a route, or a path that it is given."""

    def set_destination(self, destination: carla.Location, start: carla.Location | None = None) -> None:
        """Plan a route from `start` (the ego's own place where None) to `destination`. Raises `RouteError`."""

    def done(self) -> bool:
        """True once the ego is at the end of its route."""
