"""A small BehaviorAgent of our own with what the recipe needs: it drives a route and stops behind obstacles.

`package` writes a package `agents` around it in the form of the public copies, which differ in what they return for an
obstacle, in the methods of their planner, in how well they steer, and in how near to an obstacle they stop.
"""

from __future__ import annotations

import enum
import math
from collections import deque
from pathlib import Path
from typing import Any

import carla

STEP_M = 2.0
SPEED_KMH, BRAKE = 24.0, 0.5
BESIDE_M = 1.5
"""An obstacle farther than this from the middle of the path does not stop the agent (m)."""
MODULES = {
    "plain": {
        "agents/navigation/local_planner.py": "from small_agent import Planner as LocalPlanner\n"
        "from small_agent import RoadOption\n",
        "agents/navigation/behavior_agent.py": """
import small_agent
from agents.navigation.local_planner import LocalPlanner


class BehaviorAgent(small_agent.Agent):
    stops_m, gain = {stops_m}, {gain}
    planner_class = LocalPlanner

    def __init__(self, vehicle, behavior="normal"):
        super().__init__(vehicle)

    def _obstacle(self):
        return self.found()
""",
    },
    "hints": {
        "agents/tools/__init__.py": "",
        "agents/tools/hints.py": """
from typing import NamedTuple, Optional

from carla import Actor


class ObstacleDetectionResult(NamedTuple):
    obstacle_was_found: bool
    obstacle: Optional[Actor]
    distance: float
""",
        "agents/navigation/local_planner.py": "from small_agent import PlannerWithPlan as LocalPlanner\n"
        "from small_agent import RoadOption\n",
        "agents/navigation/behavior_agent.py": """
import small_agent
from agents.navigation.local_planner import LocalPlanner
from agents.tools.hints import ObstacleDetectionResult


class BehaviorAgent(small_agent.Agent):
    stops_m, gain = {stops_m}, {gain}
    planner_class = LocalPlanner

    def __init__(self, vehicle, behavior="normal", opt_dict={{}}, map_inst=None, grp_inst=None):
        super().__init__(vehicle, map_inst)

    def set_destination(self, end_location, start_location=None, clean_queue=True):
        super().set_destination(end_location, start_location)

    def _obstacle(self):
        return ObstacleDetectionResult(*self.found())
""",
    },
}


def package(folder: Path, variant: str, stops_m: float, gain: float) -> Path:
    """Write the package `agents` of a variant into a folder, and return the folder.

    `stops_m`: gap that the agent keeps to a stopped obstacle (m). `gain`: steering per radian of heading error.
    """
    empty = {"agents/__init__.py": "", "agents/navigation/__init__.py": ""}
    for name, text in {**empty, **MODULES[variant]}.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text.format(stops_m=stops_m, gain=gain) if "stops_m" in text else text, encoding="utf-8")
    return folder


class RoadOption(enum.Enum):
    """As in `agents.navigation.local_planner`."""

    VOID = -1
    LEFT = 1
    RIGHT = 2
    STRAIGHT = 3
    LANEFOLLOW = 4
    CHANGELANELEFT = 5
    CHANGELANERIGHT = 6


class Planner:
    """Steers at the next waypoint of its plan, with a limited change of the steering per tick."""

    def __init__(self, vehicle: Any, gain: float) -> None:
        self._vehicle, self._gain, self._steer, self._target_kmh = vehicle, gain, 0.0, SPEED_KMH
        self._waypoints_queue: deque[Any] = deque()
        self.target_road_option = RoadOption.LANEFOLLOW

    def set_speed(self, speed: float) -> None:
        self._target_kmh = speed

    def set_global_plan(self, plan: Any, stop_waypoint_creation: bool = True, clean_queue: bool = True) -> None:
        if clean_queue:
            self._waypoints_queue.clear()
        self._waypoints_queue.extend(plan)

    def run_step(self) -> Any:
        transform, speed = self._vehicle.get_transform(), self._vehicle.get_velocity().length()
        here, queue = transform.location, self._waypoints_queue
        while queue and here.distance(queue[0][0].transform.location) < (1.0 if len(queue) == 1 else 3.0 + 0.5 * speed):
            queue.popleft()
        if not queue:
            return carla.VehicleControl(brake=1.0)
        goal = queue[0][0].transform.location
        off = math.atan2(goal.y - here.y, goal.x - here.x) - math.radians(transform.rotation.yaw)
        wanted = min(max(self._gain * math.remainder(off, math.tau), -0.8), 0.8)
        self._steer += min(max(wanted - self._steer, -0.1), 0.1)
        pedal = 0.3 * (self._target_kmh / 3.6 - speed)
        if pedal >= 0.0:
            return carla.VehicleControl(throttle=min(pedal, 0.75), steer=self._steer)
        return carla.VehicleControl(brake=min(-pedal, BRAKE), steer=self._steer)


class PlannerWithPlan(Planner):
    """Since 0.9.13."""

    def get_plan(self) -> Any:
        return self._waypoints_queue


class Agent:
    """Drives its plan, and brakes for a vehicle in it."""

    planner_class: type[Planner]
    stops_m: float
    gain: float

    def __init__(self, vehicle: Any, carla_map: Any = None) -> None:
        self._vehicle, self._world = vehicle, vehicle.get_world()
        self._map = carla_map or self._world.get_map()
        self._planner = self.planner_class(vehicle, self.gain)

    def get_local_planner(self) -> Planner:
        return self._planner

    def set_global_plan(self, plan: Any, stop_waypoint_creation: bool = True, clean_queue: bool = True) -> None:
        self._planner.set_global_plan(plan, stop_waypoint_creation, clean_queue)

    def set_destination(self, end_location: Any, start_location: Any = None) -> None:
        start = self._map.get_waypoint(start_location or self._vehicle.get_location())
        self.set_global_plan(self.trace_route(start, self._map.get_waypoint(end_location)))

    def trace_route(self, start: Any, end: Any) -> Any:
        """Return the way along a street: in the start's lane, and near the end in the end's."""
        plan, here, changed = [(start, RoadOption.LANEFOLLOW)], start, False
        while here.transform.location.distance(end.transform.location) > STEP_M and len(plan) < 200:
            onward = here.next(STEP_M)
            if not onward:
                break
            here, option = onward[0], RoadOption.LANEFOLLOW
            beside = {
                RoadOption.CHANGELANELEFT: here.get_left_lane(),
                RoadOption.CHANGELANERIGHT: here.get_right_lane(),
            }
            for change, lane in beside.items():
                wanted = lane is not None and (lane.road_id, lane.lane_id) == (end.road_id, end.lane_id)
                if wanted and here.lane_id != end.lane_id and not changed:
                    here, option, changed = lane, change, True
            plan.append((here, option))
        return plan

    def done(self) -> bool:
        return not self._planner._waypoints_queue

    def found(self) -> tuple[bool, Any, float]:
        """Return whether a vehicle is in the plan's next waypoints, the vehicle, and its gap (m)."""
        transform, half_m = self._vehicle.get_transform(), self._vehicle.bounding_box.extent.x
        ahead = [w.transform.location for w, _ in list(self._planner._waypoints_queue)[:15]]
        for other in self._world.get_actors().filter("*vehicle*"):
            place = other.get_location()
            along = transform.get_forward_vector()
            away_m = (place.x - transform.location.x) * along.x + (place.y - transform.location.y) * along.y
            near = any(place.distance(spot) < BESIDE_M for spot in ahead)
            if other.id != self._vehicle.id and away_m > 0.0 and near:
                return True, other, away_m - half_m - other.bounding_box.extent.x
        return False, None, -1.0

    def run_step(self, debug: bool = False) -> Any:
        was_found, _, gap_m = self._obstacle()
        control = self._planner.run_step()
        speed = self._vehicle.get_velocity().length()
        if was_found and speed * speed / (2.0 * 4.0) > gap_m - self.stops_m - 0.3:
            control.throttle, control.brake = 0.0, 0.7
        return control

    def _obstacle(self) -> tuple[bool, Any, float]:
        raise NotImplementedError
