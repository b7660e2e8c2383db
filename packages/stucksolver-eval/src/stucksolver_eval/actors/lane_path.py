"""The path that a simulated car follows: lane centers, extended as it drives, with its junctions and traffic lights."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from stucksolver_bridge.traffic_side import drives_on_left

if TYPE_CHECKING:
    import carla

STEP_M = 2.0
"""Distance between path points (m). Ours."""
_LATERAL_MPS2 = 2.5
"""Lateral acceleration in bends (m/s²). Ours."""
_SLOWING_MPS2 = 2.0
"""Deceleration before bends (m/s²). Ours."""

Chooser = Callable[[Sequence[Any]], Any]
"""Selects one of the `carla.Waypoint`s that follow a lane."""


class JunctionSpan(NamedTuple):
    """A junction on the path: its id, and the arc lengths at which the path enters and leaves it (m)."""

    junction: int
    enter_s: float
    leave_s: float


class StopOnPath(NamedTuple):
    """The point at which a traffic light stops a lane, in CARLA's world frame (m)."""

    light: carla.TrafficLight
    x: float
    y: float


class StopAt(NamedTuple):
    """A traffic light and the arc length of its stop line on a path (m)."""

    light: carla.TrafficLight
    s: float


StopLines = dict[tuple[int, int], StopOnPath]
"""Stop points by road id and lane id."""


def stop_lines(lights: Sequence[carla.TrafficLight]) -> StopLines:
    """Return the stop points of the traffic lights."""
    found: StopLines = {}
    for light in lights:
        for waypoint in light.get_stop_waypoints():
            place = waypoint.transform.location
            found[waypoint.road_id, waypoint.lane_id] = StopOnPath(light, place.x, place.y)
    return found


class LanePath:
    """A path along lane centers that starts at a waypoint. World frame of CARLA; meters and radians.

    Args:
        waypoints: First waypoints of the path.
        lane_chooser: Chooses the lane at forks; straight on by default.
        offset_m: Shifts the path from the lane's center toward the road's edge, the right in right-hand traffic.
        merge: (offset, length): the path starts with this offset, and reaches `offset_m` within `length`.
        ends: True if the path ends at the last of `waypoints`; otherwise it ends where the lanes end.
        stops: Stop points of traffic lights.
    """

    def __init__(
        self,
        waypoints: Sequence[carla.Waypoint],
        lane_chooser: Chooser | None = None,
        offset_m: float = 0.0,
        merge: tuple[float, float] = (0.0, 0.0),
        ends: bool = False,
        stops: StopLines | None = None,
    ) -> None:
        self._lane_chooser = lane_chooser or straightest
        self._offset_m, self._merge = offset_m, merge
        self._edge_side = -1.0 if drives_on_left(waypoints[0]) else 1.0
        self._stops = stops or {}
        self._last = waypoints[0]
        self._ended = False
        self.x: list[float] = []
        self.y: list[float] = []
        self.z: list[float] = []
        self.yaw: list[float] = []
        self.s: list[float] = []
        self.limit_mps: list[float] = []
        self.lights: list[StopAt] = []
        self.crossings: list[JunctionSpan] = []
        self.at = 0
        """Index of the path point nearest to the car."""
        for waypoint in waypoints:
            self._append(waypoint)
        self._ended = ends

    @property
    def waypoint(self) -> carla.Waypoint:
        """The last known waypoint of the path."""
        return self._last

    @property
    def ended(self) -> bool:
        """True if the path cannot be extended."""
        return self._ended

    def advance(self, x: float, y: float) -> float:
        """Update the car's position and return its arc length (m)."""
        i, n = self.at, len(self.x)
        here = (self.x[i] - x) ** 2 + (self.y[i] - y) ** 2
        while i + 1 < n:
            there = (self.x[i + 1] - x) ** 2 + (self.y[i + 1] - y) ** 2
            if there > here:
                break
            i, here = i + 1, there
        self.at = i
        return self.s[i] + (x - self.x[i]) * math.cos(self.yaw[i]) + (y - self.y[i]) * math.sin(self.yaw[i])

    def grow(self, until_s: float) -> None:
        """Extend the path to this arc length (m), if the lanes are long enough."""
        while not self._ended and self.s[-1] < until_s:
            options = self._last.next(STEP_M)
            if not options:
                self._ended = True
                return
            self._append(options[0] if len(options) == 1 else self._lane_chooser(options))

    def point(self, s: float) -> tuple[float, float]:
        """Return the position at an arc length (m); it is extrapolated straight beyond the ends."""
        i = self.at
        n = len(self.s)
        while i + 1 < n and self.s[i + 1] < s:
            i += 1
        over = s - self.s[i]
        if i + 1 < n and over > 0.0:
            share = over / max(self.s[i + 1] - self.s[i], 1e-6)
            return self.x[i] + share * (self.x[i + 1] - self.x[i]), self.y[i] + share * (self.y[i + 1] - self.y[i])
        return self.x[i] + over * math.cos(self.yaw[i]), self.y[i] + over * math.sin(self.yaw[i])

    def speed_limit(self) -> float:
        """Return the highest speed here that suits the bends ahead (m/s)."""
        i = min(self.at + 1, len(self.limit_mps) - 1)
        return self.limit_mps[i]

    def _append(self, waypoint: carla.Waypoint) -> None:
        transform = waypoint.transform
        place, yaw = transform.location, math.radians(transform.rotation.yaw)
        shift = self._edge_side * self._shift(self.s[-1] + STEP_M if self.s else 0.0)
        x, y = place.x - shift * math.sin(yaw), place.y + shift * math.cos(yaw)
        if self.s:
            gone = math.hypot(x - self.x[-1], y - self.y[-1])
            if gone < 0.3:
                self._last = waypoint
                return
            s, turn = self.s[-1] + gone, abs(math.remainder(yaw - self.yaw[-1], math.tau))
        else:
            s, gone, turn = 0.0, STEP_M, 0.0
        self.x.append(x)
        self.y.append(y)
        self.z.append(place.z)
        self.yaw.append(yaw)
        self.s.append(s)
        self.limit_mps.append(math.sqrt(_LATERAL_MPS2 * gone / turn) if turn > 0.01 else math.inf)
        self._slow_before_bends()
        self._note_junction(waypoint, s)
        self._note_light(waypoint, s)
        self._last = waypoint

    def _shift(self, s: float) -> float:
        begin, over = self._merge
        if over <= 0.0 or s >= over:
            return self._offset_m
        share = s / over
        smooth = share * share * (3.0 - 2.0 * share)
        return begin + (self._offset_m - begin) * smooth

    def _slow_before_bends(self) -> None:
        i = len(self.limit_mps) - 1
        while i > self.at:
            allowed = math.sqrt(self.limit_mps[i] ** 2 + 2.0 * _SLOWING_MPS2 * (self.s[i] - self.s[i - 1]))
            if self.limit_mps[i - 1] <= allowed:
                return
            self.limit_mps[i - 1] = allowed
            i -= 1

    def _note_junction(self, waypoint: carla.Waypoint, s: float) -> None:
        if not waypoint.is_junction:
            return
        number = waypoint.junction_id
        if self.crossings and self.crossings[-1].junction == number and s - self.crossings[-1].leave_s < 2.5 * STEP_M:
            self.crossings[-1] = self.crossings[-1]._replace(leave_s=s)
        else:
            self.crossings.append(JunctionSpan(number, max(s - STEP_M, 0.0), s))

    def _note_light(self, waypoint: carla.Waypoint, s: float) -> None:
        stop = self._stops.get((waypoint.road_id, waypoint.lane_id))
        if stop is None or (self.lights and self.lights[-1].light is stop.light):
            return
        dx, dy = stop.x - self.x[-1], stop.y - self.y[-1]
        if dx * dx + dy * dy < (1.5 * STEP_M) ** 2:
            ahead = dx * math.cos(self.yaw[-1]) + dy * math.sin(self.yaw[-1])
            self.lights.append(StopAt(stop.light, s + ahead))


def straightest(options: Sequence[carla.Waypoint]) -> carla.Waypoint:
    """Return the option with the least change of heading over the next 10 m."""
    return min(options, key=_turn)


def _turn(waypoint: carla.Waypoint) -> float:
    ahead = waypoint.next(10.0)
    if not ahead:
        return 180.0
    return abs(math.remainder(ahead[0].transform.rotation.yaw - waypoint.transform.rotation.yaw, 360.0))
