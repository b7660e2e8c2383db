"""The route that an observer assumes: along the car's lane, straight on wherever the road divides."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Any, NoReturn

from stucksolver.stacks.driver import DrivePoint, RoutePoint

STEP_M = 1.0
LENGTH_M = 400


class Ahead:
    """A driver in name only: it has a route, and refuses to drive it."""

    def __init__(self, vehicle: Any, carla_map: Any) -> None:
        self._vehicle = vehicle
        self._map = carla_map
        self.route: Sequence[RoutePoint] = ()
        self.look()

    def look(self) -> None:
        """Assume the route anew from where the car is."""
        waypoint = self._map.get_waypoint(self._vehicle.get_location())
        found = [RoutePoint(waypoint, "lane_follow")]
        for _ in range(LENGTH_M):
            onwards = waypoint.next(STEP_M)
            if not onwards:
                break
            turns = [_turn(waypoint, other) for other in onwards]
            waypoint = onwards[turns.index(min(turns))]
            found.append(RoutePoint(waypoint, "lane_follow"))
        self.route = found

    def set_destination(self, destination: Any, start: Any | None = None) -> NoReturn:
        raise _hands_off()

    def run_step(self) -> NoReturn:
        raise _hands_off()

    def follow(self, path: Sequence[DrivePoint], reverse: bool = False, ignore: Collection[int] = ()) -> NoReturn:
        raise _hands_off()

    def hold(self, brake_mps2: float | None = None) -> NoReturn:
        raise _hands_off()

    def release(self) -> NoReturn:
        raise _hands_off()

    def done(self) -> bool:
        return False


def _turn(here: Any, other: Any) -> float:
    """How far a waypoint turns away from another, degrees."""
    return abs(math.remainder(other.transform.rotation.yaw - here.transform.rotation.yaw, 360.0))


def _hands_off() -> RuntimeError:
    return RuntimeError("an observed car is never driven")
