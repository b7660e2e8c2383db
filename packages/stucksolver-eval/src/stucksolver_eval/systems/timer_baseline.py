"""The timer-based baseline: a car that is stopped for too long tries one action after another, without perception.

After 8 s without motion it waits, after 15 s it reverses, after 30 s it overtakes on the left, and after 60 s on the
right (in left-hand traffic the other way round); then it starts again. It has no information about the cause. Only its
driver's own braking prevents collisions.
The numbers are ours.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from stucksolver.plan import Directive
from stucksolver_bridge.traffic_side import drives_on_left
from stucksolver_carla.drivers.behavior import DrivePoint
from stucksolver_carla.stack.client_interface import EgoVehicle
from stucksolver_eval.criteria.criterion import STANDING_MPS
from stucksolver_eval.drivers import RouteDriver
from stucksolver_eval.results.outcome import InterventionRecord
from stucksolver_eval.routes.route_line import RouteLine
from stucksolver_eval.systems.system_under_test import SystemLog, TickInfo

WAIT_S = 8.0
"""Stopped time after which the car waits (s)."""
REVERSE_S = 15.0
"""Stopped time after which it reverses (s)."""
LEFT_S = 30.0
"""Stopped time after which it overtakes on the left (s)."""
RIGHT_S = 60.0
"""Stopped time after which it overtakes on the right (s)."""
REVERSE_M = 5.0
"""Length of the reverse path (m)."""
REVERSE_MPS = 1.5
"""Speed in reverse (m/s)."""
OVER_M = 12.0
"""Length of a lane change (m)."""
BESIDE_M = 25.0
"""Length of the path in the adjacent lane (m)."""
OVERTAKE_MPS = 5.0
"""Speed of overtaking (m/s)."""
ACTION_LIMIT_S = 15.0
"""Time limit of an action (s)."""
GOING_M = 15.0
"""New progress that restarts all timers (m)."""

Path = list[DrivePoint]


@dataclass(frozen=True)
class _Action:
    after_s: float
    name: str
    path: Callable[[], Path]
    reverse: bool = False


class TimerSystem:
    """The timers count the time with less than `GOING_M` of new progress since the car stopped."""

    def __init__(self, ego: EgoVehicle, driver: RouteDriver, line: RouteLine) -> None:
        self._ego, self._driver, self._line = ego, driver, line
        sides = {"left": -1.0, "right": 1.0}
        inner, outer = ("right", "left") if drives_on_left(line.waypoints[0]) else ("left", "right")
        self._actions = (
            _Action(WAIT_S, "wait", list),
            _Action(REVERSE_S, "reverse", self._back, reverse=True),
            _Action(LEFT_S, f"overtake {inner}", lambda: self._adjacent_path(sides[inner])),
            _Action(RIGHT_S, f"overtake {outer}", lambda: self._adjacent_path(sides[outer])),
        )
        self._stuck_s: float | None = None
        self._place_m = 0.0
        self._next = 0
        self._running: InterventionRecord | None = None
        self.log = SystemLog()
        self.directive: Directive | None = None

    def say(self, text: str) -> None:
        """Ignore the utterance."""

    def step(self, now: TickInfo) -> Any:
        """Run one tick of the timers and return the driver's control."""
        self._watch(now)
        if self._running is not None:
            self._go_on(self._running, now)
        elif self._stuck_s is not None and now.time_s - self._stuck_s >= self._actions[self._next].after_s:
            self._act(self._actions[self._next], now)
        return self._driver.run_step()

    def close(self, time_s: float) -> None:
        """Log the running action as unfinished, if there is one."""
        if self._running is not None:
            self._end(self._running, time_s, False, "the route ended")

    def _watch(self, now: TickInfo) -> None:
        if self._stuck_s is None:
            if now.speed_mps < STANDING_MPS:
                self._stuck_s, self._place_m, self._next = now.time_s, now.place_m, 0
        elif now.place_m - self._place_m > GOING_M or (self._next == 0 and now.speed_mps > 1.0):
            self._stuck_s = None

    def _act(self, action: _Action, now: TickInfo) -> None:
        self._next += 1
        path = action.path()
        if path:
            self._driver.follow(path, reverse=action.reverse)
        self._running = InterventionRecord(
            start_s=now.time_s,
            end_s=now.time_s,
            place_m=now.place_m,
            rung=action.name,
            behaviors=(action.name,),
            moves=bool(path),
            finished=False,
        )
        if not path:
            self._end(self._running, now.time_s, True, "waited")

    def _go_on(self, running: InterventionRecord, now: TickInfo) -> None:
        arrived = self._driver.path_left_m < 1.0
        late = now.time_s - running.start_s > ACTION_LIMIT_S
        if arrived or late:
            self._driver.release()
            self._end(running, now.time_s, arrived, "driven" if arrived else f"not done within {ACTION_LIMIT_S:.0f} s")

    def _end(self, running: InterventionRecord, time_s: float, finished: bool, text: str) -> None:
        update = {"end_s": time_s, "finished": finished, "text": text}
        self.log.interventions.append(running.model_copy(update=update))
        self._running = None
        if self._next == len(self._actions):
            self._stuck_s, self._next = None, 0

    def _back(self) -> Path:
        """Return a path straight back from the ego."""
        place = self._ego.get_transform()
        yaw = math.radians(place.rotation.yaw)
        x, y = place.location.x, place.location.y
        steps = range(int(REVERSE_M) + 1)
        return [DrivePoint(x - k * math.cos(yaw), y - k * math.sin(yaw), REVERSE_MPS) for k in steps]

    def _adjacent_path(self, side: float) -> Path:
        """Return a path along the route that changes over by one lane and back; `side` is 1 for right, -1 for left."""
        here = self._line.project(self._ego.get_location())
        start_m = float(self._line.s_m[here])
        path = []
        for point, s_m in zip(self._line.waypoints[here:], self._line.s_m[here:].tolist(), strict=True):
            ahead_m = s_m - start_m
            if ahead_m > 2.0 * OVER_M + BESIDE_M:
                break
            over = min(ahead_m, 2.0 * OVER_M + BESIDE_M - ahead_m) / OVER_M
            aside = side * float(point.lane_width) * _smooth(min(max(over, 0.0), 1.0))
            right = point.transform.get_right_vector()
            place = point.transform.location
            path.append(DrivePoint(place.x + aside * right.x, place.y + aside * right.y, OVERTAKE_MPS))
        return path if len(path) > 2 else []


def _smooth(share: float) -> float:
    return share * share * (3.0 - 2.0 * share)
