"""Runs the timer-based baseline with BehaviorAgent: a stopped ego starts one action after another, unchecked.

After 8 s at a standstill the ego continues to wait, after 15 s it reverses, after 30 s it passes on the left and after
60 s on the right; then the cycle starts again. `stucksolver_eval.systems.timer_baseline` does the same with the
built-in driver.
"""

from __future__ import annotations

import math
from typing import Any, Callable

from stucksolver_bridge.agent_driver import AgentDriver

REVERSE_S = 15.0
"""Standstill after which the ego reverses (s)."""
LEFT_S = 30.0
"""Standstill after which the ego passes on the left (s)."""
RIGHT_S = 60.0
"""Standstill after which the ego passes on the right (s)."""
REVERSE_M = 5.0
"""Length of the reverse path (m). Ours."""
REVERSE_MPS = 1.5
"""Speed of reversing (m/s). Ours."""
LANE_CHANGE_M = 12.0
"""Length of each of the two lane changes of a pass (m). Ours."""
OFFSET_LENGTH_M = 25.0
"""Length in the adjacent lane between the two lane changes (m). Ours."""
OVERTAKE_MPS = 5.0
"""Speed of a pass (m/s). Ours."""
ACTION_LIMIT_S = 15.0
"""Maximum duration of an action (s). Ours."""
PROGRESS_M = 15.0
"""Distance from the place of the standstill that ends it (m): all timers start again."""
STOPPED_MPS = 0.1
"""Speed below which the ego counts as stopped (m/s). Ours."""


class TimerBaseline:
    """The baseline, with the methods of `RecoveryClient`."""

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
        self._stopped: tuple[float, Any] | None = None
        """Time (s) and location of the standstill; None while the ego is driving."""
        self._next_action = 0
        self._began_s: float | None = None

    def run_step(self) -> Any:
        """Return this tick's `carla.VehicleControl`, not applied."""
        now = float(self._world.get_snapshot().timestamp.elapsed_seconds)
        self._update_timer(now)
        if self._began_s is not None:
            if self._driver.path_left_m < 1.0 or now - self._began_s > ACTION_LIMIT_S:
                self._end_action(now)
        elif self._stopped is not None and now - self._stopped[0] >= self._actions[self._next_action][0]:
            self._start_action(now)
        return self._driver.run_step()

    def say(self, text: str) -> None:
        """Ignore a passenger's utterance: the timers use none."""

    def close(self) -> None:
        """Do nothing, because the baseline has no process."""

    def _update_timer(self, now: float) -> None:
        velocity, place = self._vehicle.get_velocity(), self._vehicle.get_location()
        speed = math.hypot(velocity.x, velocity.y)
        if self._stopped is None:
            if speed < STOPPED_MPS:
                self._stopped, self._next_action = (now, place), 0
        elif self._stopped[1].distance(place) > PROGRESS_M or (self._next_action == 0 and speed > 1.0):
            self._stopped = None

    def _start_action(self, now: float) -> None:
        _, name, reverse = self._actions[self._next_action]
        self._next_action += 1
        path = self._back_up_path() if reverse else self._lane_shift_path(-1.0 if name.endswith("left") else 1.0)
        if len(path) > 2:
            self._began_s = now
            self._driver.follow(path, reverse)
            self._emit(now, "started", name)
        else:
            self._end_action(now)

    def _end_action(self, now: float) -> None:
        self._driver.release()
        self._began_s = None
        self._emit(now, "finished", self._actions[self._next_action - 1][1])
        if self._next_action == len(self._actions):
            self._stopped = None

    def _emit(self, now: float, kind: str, text: str) -> None:
        if self._on_event is not None:
            self._on_event({"time_s": now, "kind": kind, "text": text, "verdict": None})

    def _back_up_path(self) -> list[tuple[float, float, float]]:
        transform = self._vehicle.get_transform()
        yaw, x, y = math.radians(transform.rotation.yaw), transform.location.x, transform.location.y
        return [(x - k * math.cos(yaw), y - k * math.sin(yaw), REVERSE_MPS) for k in range(int(REVERSE_M) + 1)]

    def _lane_shift_path(self, side: float) -> list[tuple[float, float, float]]:
        """Return an unchecked path into the adjacent lane and back; `side` is 1 for the right, -1 for the left."""
        here = self._vehicle.get_location()
        route = [point.waypoint for point in self._driver.route]
        first = min(range(len(route)), key=lambda i: float(route[i].transform.location.distance(here)), default=0)
        path: list[tuple[float, float, float]] = []
        whole, ahead = 2.0 * LANE_CHANGE_M + OFFSET_LENGTH_M, 0.0
        for i in range(first, len(route)):
            transform = route[i].transform
            if i > first:
                ahead += float(transform.location.distance(route[i - 1].transform.location))
            if ahead > whole:
                break
            share = min(max(min(ahead, whole - ahead) / LANE_CHANGE_M, 0.0), 1.0)
            offset_m = side * float(route[i].lane_width) * share * share * (3.0 - 2.0 * share)
            right = transform.get_right_vector()
            path.append(
                (transform.location.x + offset_m * right.x, transform.location.y + offset_m * right.y, OVERTAKE_MPS)
            )
        return path
