"""The timer-based baseline with BehaviorAgent: a stopped car tries one action after another, without looking.

After 8 s at a standstill it keeps waiting, after 15 s it reverses, after 30 s it overtakes on the left and after 60 s
on the right; then it starts again. `stucksolver_eval.systems.timer_baseline` does the same with our own driver.
"""

from __future__ import annotations

import math
from typing import Any, Callable

from stucksolver_bridge.agent_driver import AgentDriver

REVERSE_S = 15.0
LEFT_S = 30.0
RIGHT_S = 60.0
REVERSE_M = 5.0
REVERSE_MPS = 1.5
OVER_M = 12.0
BESIDE_M = 25.0
OVERTAKE_MPS = 5.0
ACTION_LIMIT_S = 15.0
GOING_M = 15.0
"""This much progress ends the standstill: all timers start again."""
STANDING_MPS = 0.1


class TimerBaseline:
    """Use it like `Recovery`."""

    fault: str | None = None

    def __init__(self, driver: AgentDriver, on_event: Callable[[dict[str, Any]], None] | None = None) -> None:
        self._driver = driver
        self._vehicle = driver.vehicle
        self._world = driver.vehicle.get_world()
        self._on_event = on_event
        self._actions: tuple[tuple[float, str, bool], ...] = (
            (REVERSE_S, "reverse", True),
            (LEFT_S, "overtake left", False),
            (RIGHT_S, "overtake right", False),
        )
        self._stuck: tuple[float, Any] | None = None
        """Since when the vehicle has been stationary, and where."""
        self._next = 0
        self._began_s: float | None = None

    def run_step(self) -> Any:
        """Return this tick's `carla.VehicleControl`, not applied."""
        now = float(self._world.get_snapshot().timestamp.elapsed_seconds)
        self._watch(now)
        if self._began_s is not None:
            if self._driver.path_left_m < 1.0 or now - self._began_s > ACTION_LIMIT_S:
                self._end(now)
        elif self._stuck is not None and now - self._stuck[0] >= self._actions[self._next][0]:
            self._act(now)
        return self._driver.run_step()

    def say(self, text: str) -> None:
        """Ignore a passenger's words: timers do not listen."""

    def close(self) -> None:
        """Do nothing: no process has to be ended."""

    def _watch(self, now: float) -> None:
        velocity, place = self._vehicle.get_velocity(), self._vehicle.get_location()
        speed = math.hypot(velocity.x, velocity.y)
        if self._stuck is None:
            if speed < STANDING_MPS:
                self._stuck, self._next = (now, place), 0
        elif self._stuck[1].distance(place) > GOING_M or (self._next == 0 and speed > 1.0):
            self._stuck = None

    def _act(self, now: float) -> None:
        _, name, reverse = self._actions[self._next]
        self._next += 1
        path = self._back() if reverse else self._beside(-1.0 if name.endswith("left") else 1.0)
        if len(path) > 2:
            self._began_s = now
            self._driver.follow(path, reverse)
            self._tell(now, "started", name)
        else:
            self._end(now)

    def _end(self, now: float) -> None:
        self._driver.release()
        self._began_s = None
        self._tell(now, "finished", self._actions[self._next - 1][1])
        if self._next == len(self._actions):
            self._stuck = None

    def _tell(self, now: float, kind: str, text: str) -> None:
        if self._on_event is not None:
            self._on_event({"time_s": now, "kind": kind, "text": text, "verdict": None})

    def _back(self) -> list[tuple[float, float, float]]:
        place = self._vehicle.get_transform()
        yaw, x, y = math.radians(place.rotation.yaw), place.location.x, place.location.y
        return [(x - k * math.cos(yaw), y - k * math.sin(yaw), REVERSE_MPS) for k in range(int(REVERSE_M) + 1)]

    def _beside(self, side: float) -> list[tuple[float, float, float]]:
        """Return a path one lane to the side along the route and back; `side` is 1 for the right. It checks nothing."""
        here = self._vehicle.get_location()
        route = [point.waypoint for point in self._driver.route]
        first = min(range(len(route)), key=lambda i: float(route[i].transform.location.distance(here)), default=0)
        path: list[tuple[float, float, float]] = []
        whole, ahead = 2.0 * OVER_M + BESIDE_M, 0.0
        for i in range(first, len(route)):
            transform = route[i].transform
            if i > first:
                ahead += float(transform.location.distance(route[i - 1].transform.location))
            if ahead > whole:
                break
            share = min(max(min(ahead, whole - ahead) / OVER_M, 0.0), 1.0)
            aside = side * float(route[i].lane_width) * share * share * (3.0 - 2.0 * share)
            right = transform.get_right_vector()
            path.append((transform.location.x + aside * right.x, transform.location.y + aside * right.y, OVERTAKE_MPS))
        return path
