"""An agent with the methods of CARLA's BehaviorAgent and its way of failing, in as little code as that takes.

It stands in for the public copies of `agents`, which are not part of this repository: they differ in when the last
waypoint is dropped and in what they do next, and all of them look at a waypoint that is no longer there.
"""

from __future__ import annotations

import enum
import math
from collections import deque
from typing import Any

import carla


class RoadOption(enum.Enum):
    """As in `agents.navigation.local_planner`."""

    VOID = -1
    LEFT = 1
    RIGHT = 2
    STRAIGHT = 3
    LANEFOLLOW = 4
    CHANGELANELEFT = 5
    CHANGELANERIGHT = 6


class FakePlanner:
    """Steers straight at the first waypoint that it has not dropped; the last one is dropped `last_m` away from it."""

    def __init__(self, vehicle: Any, last_m: float) -> None:
        self._vehicle = vehicle
        self._last_m = last_m
        self._waypoints_queue: deque[Any] = deque()
        self.target_road_option = RoadOption.LANEFOLLOW
        self._target_kmh = 20.0

    def set_speed(self, speed: float) -> None:
        self._target_kmh = speed

    def set_global_plan(self, plan: Any, stop_waypoint_creation: bool = True, clean_queue: bool = True) -> None:
        if clean_queue:
            self._waypoints_queue.clear()
        self._waypoints_queue.extend(plan)

    def run_step(self) -> Any:
        transform, velocity = self._vehicle.get_transform(), self._vehicle.get_velocity()
        here, speed = transform.location, velocity.length()
        queue = self._waypoints_queue
        while queue:
            near = self._last_m if len(queue) == 1 else 3.0 + 0.5 * speed
            if here.distance(queue[0][0].transform.location) >= near:
                break
            queue.popleft()
        if not queue:
            return carla.VehicleControl(brake=1.0)
        goal = queue[0][0].transform.location
        off = math.atan2(goal.y - here.y, goal.x - here.x) - math.radians(transform.rotation.yaw)
        steer = min(max(1.2 * math.remainder(off, math.tau), -0.8), 0.8)
        return carla.VehicleControl(throttle=0.5 if 3.6 * speed < self._target_kmh else 0.0, steer=steer)


class PlannerWithPlan(FakePlanner):
    """Since 0.9.13."""

    def get_plan(self) -> Any:
        return self._waypoints_queue


class FakeAgent:
    """Fails as CARLA's do on the tick after its plan has run out. Takes no map, as those before 0.9.14."""

    planner_class: type[FakePlanner] = PlannerWithPlan
    last_m = 1.0

    def __init__(self, vehicle: Any, behavior: str = "normal") -> None:
        self._vehicle = vehicle
        self._world = vehicle.get_world()
        self._map = self._world.get_map()
        self._planner = self.planner_class(vehicle, self.last_m)

    def get_local_planner(self) -> FakePlanner:
        return self._planner

    def set_global_plan(self, plan: Any, stop_waypoint_creation: bool = True, clean_queue: bool = True) -> None:
        self._planner.set_global_plan(plan, stop_waypoint_creation, clean_queue)

    def trace_route(self, start: Any, end: Any) -> Any:
        raise NotImplementedError

    def done(self) -> bool:
        return not self._planner._waypoints_queue

    def run_step(self, debug: bool = False) -> Any:
        queue = self._planner._waypoints_queue
        incoming = queue[min(3, len(queue) - 1)][0] if queue else None
        assert incoming.is_junction is not None  # 'NoneType' object has no attribute 'is_junction'
        return self._planner.run_step()


class EarlyAgent(FakeAgent):
    """Drops the last waypoint earlier, shows no plan (before 0.9.13), and takes the map."""

    planner_class = FakePlanner
    last_m = 2.5

    def __init__(self, vehicle: Any, behavior: str = "normal", map_inst: Any = None) -> None:
        super().__init__(vehicle, behavior)
        assert map_inst is not None
        self._map = map_inst
