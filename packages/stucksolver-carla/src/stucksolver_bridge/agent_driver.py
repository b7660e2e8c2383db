"""Wraps CARLA's BehaviorAgent (`agents.navigation`, 0.9.12 and later) as a driver that can follow a given path.

The agent is not changed. It drives by its own rules until a path is set. Then its local planner and its controllers
drive that path, and its own decisions are suspended until `release`. The agent cannot reverse, so this module computes
the steering for backing up. Python 3.7, standard library only; `carla` is passed in.
"""

from __future__ import annotations

import math
from typing import Any, Callable, Collection, Iterable, NamedTuple, Sequence

from stucksolver_bridge.actor_boxes import ActorBoxes
from stucksolver_bridge.agent_plan import PlanExtender, check_agent, plan_of, replace_plan
from stucksolver_bridge.braking import HOLD_BRAKE, STOPPED_MPS, Braking
from stucksolver_bridge.clearance import free_way_m
from stucksolver_bridge.obstacle_exposure import ObstacleExposingWorld, props_around
from stucksolver_bridge.path_line import PathLine

LOOK_AHEAD_M, LOOK_AHEAD_S = 2.8, 0.45
"""Distance of the target point ahead of the ego's center: a constant part (m) and a part that grows with speed (s).
The agent's controllers steer toward this point. Ours."""
BRAKING_MPS2 = 3.0
"""Deceleration for the path's speed bounds and for obstacles in the path (m/s²). Ours."""
STOP_GAP_M = 1.2
"""Gap to an obstacle in the path at which the ego stops (m). Ours."""
TICK_S = 0.05
"""Length of a tick if the client reports none (s): CARLA's usual 20 Hz."""
MAX_SPACING_M = 1.5
"""Maximum distance between two waypoints of a plan (m). If they are farther apart, others are added between them."""
REJOIN_M = 5.0
"""Maximum distance to a plan's start without a connecting piece of lane, and minimum distance to the waypoint where the
ego rejoins its own plan (m). Ours."""
BACK_REACH_M = 3.0
"""Distance of the target point along the path when backing up (m). Ours."""
WHEEL_BASE_M, WHEEL_LOCK_RAD = 2.9, 1.22
"""Wheelbase (m) and maximum wheel angle (rad; 70 degrees) of most cars in CARLA. For other cars, the feedback of the
target point corrects the steering."""


class AgentRoutePoint(NamedTuple):
    """A `carla.Waypoint` of the route and the maneuver there (`lane_follow`, `left`, `change_left`, ...)."""

    waypoint: Any
    command: str


class Target:
    """Target point of the local planner, in place of a waypoint: the planner reads only a waypoint's transform."""

    is_junction = False

    def __init__(self, transform: Any) -> None:
        self.transform = transform


class AgentDriver:
    """A BehaviorAgent that can follow a given path.

    Args:
        agent: The BehaviorAgent.
        carla: The `carla` module.
        obstacles: If True, the agent gets the stationary objects of the client's ground truth as vehicles. If False, it
            gets only vehicles and walkers. A function returns the perceived obstacles (see `ObstacleExposingWorld`).
        keeps_going: If True, the ego continues along the lane beyond the end of its plan until the caller ends the
            run. An evaluator does so some meters before or after that point. If False, the ego stops there.

    Raises:
        AgentsError: This copy of the `agents` package lacks a method that is used here.
    """

    acceleration_mps2 = 3.5
    """Highest acceleration from rest (m/s²): a sedan at three quarters of full throttle, measured on carlette."""

    def __init__(self, agent: Any, carla: Any, obstacles: Any = True, keeps_going: bool = False) -> None:
        check_agent(agent)
        self.agent = agent
        self._carla = carla
        self.vehicle = agent._vehicle
        self._world = self.vehicle.get_world()
        self._map = agent._map
        self._planner = agent.get_local_planner()
        self._lane_follow = type(self._planner.target_road_option).LANEFOLLOW
        if obstacles:
            source = obstacles if callable(obstacles) else props_around(self._world, self.vehicle)
            self._expose_obstacles(source)
        self._bodies = ActorBoxes(self._world, self.vehicle.id)
        box = self.vehicle.bounding_box.extent
        self._half_size = (float(box.x), float(box.y))
        self._remaining_plan: list[tuple[Any, Any]] = []
        self._line: PathLine | None = None
        self._s = 0.0
        self._reverse = False
        self._ignore: frozenset[int] = frozenset()
        self._braking: Braking | None = None
        self._route: list[AgentRoutePoint] = []
        extender = PlanExtender(self._planner, self.vehicle, self._map, self._lane_follow)
        self._plan_extender = extender if keeps_going else None
        self.note_plan()

    def _expose_obstacles(self, source: Callable[[], Iterable[Any]]) -> None:
        if not isinstance(self.agent._world, ObstacleExposingWorld):
            self.agent._world = ObstacleExposingWorld(self.agent._world, self.vehicle, source)

    # ---- the route

    @property
    def route(self) -> Sequence[Any]:
        """The whole route as `AgentRoutePoint`s, about one per meter."""
        return self._route

    def note_plan(self) -> None:
        """Read the route again. Call this when the agent's local planner has a new plan."""
        self._set_route(plan_of(self._planner))

    def set_destination(self, destination: Any, start: Any | None = None) -> None:
        """Plan a route to a `carla.Location` with the agent's own planner; it starts at the vehicle by default."""
        begin = self._map.get_waypoint(self.vehicle.get_location() if start is None else start)
        self.set_plan(self.agent.trace_route(begin, self._map.get_waypoint(destination)))

    def set_plan(self, plan: Sequence[tuple[Any, Any]]) -> None:
        """Drive a plan: pairs of a waypoint and a road option, or a command as in `AgentRoutePoint`.

        Raises:
            ValueError: The plan has fewer than two points.
        """
        options = type(self._lane_follow)
        plan = [(waypoint, _road_option(options, option)) for waypoint, option in plan]
        if len(plan) < 2:
            raise ValueError("a plan must have at least two waypoints; use hold() to stay stopped")
        plan = [*self._lane_to(plan[0][0]), *plan]
        replace_plan(self._planner, plan)
        self._line, self._braking = None, None
        self._remaining_plan = []
        self._set_route(plan)

    def _lane_to(self, first: Any) -> list[tuple[Any, Any]]:
        """Return the lane from the ego to the start of a plan; empty if the plan does not start ahead in this lane.

        The agent checks for obstacles in the lane of a waypoint a few points ahead in its plan. Without this piece of
        lane, that waypoint may already be in another lane while the ego is still behind an obstacle.
        """
        here = self._map.get_waypoint(self.vehicle.get_location())
        if here is None or here.transform.location.distance(first.transform.location) < REJOIN_M:
            return []
        waypoints = _waypoints_between(here, first, "lane_follow")
        last = waypoints[-1].waypoint.transform.location if waypoints else here.transform.location
        arrives = last.distance(first.transform.location) < 2.0 * MAX_SPACING_M
        return [(point.waypoint, self._lane_follow) for point in waypoints] if arrives else []

    def _set_route(self, plan: Sequence[tuple[Any, Any]]) -> None:
        self._route = densified_route(plan) if len(plan) > 1 else []
        if self._plan_extender is not None:
            self._plan_extender.set_route(plan)

    @property
    def path_left_m(self) -> float:
        """Remaining length of the path that was set (m); 0 without one."""
        return 0.0 if self._line is None else max(self._line.length_m - self._s, 0.0)

    def done(self) -> bool:
        """Return True if the agent has finished its route; False while the ego follows a set path or holds."""
        return False if self._is_directed else bool(self.agent.done())

    @property
    def _is_directed(self) -> bool:
        return self._line is not None or self._braking is not None

    # ---- directives

    def follow(self, path: Sequence[Any], reverse: bool = False, ignore: Collection[int] = frozenset()) -> None:
        """Drive a path from the next step on, and brake for obstacles in it.

        Args:
            path: Points (x, y, speed bound) in CARLA's world frame (m, m/s).
            reverse: True to back up along the path.
            ignore: Ids of actors that do not count as obstacles.
        """
        line = PathLine(path)
        self._keep_plan()
        location = self.vehicle.get_location()
        self._line, self._reverse, self._ignore = line, reverse, frozenset(ignore)
        self._s = line.project(location.x, location.y, 0.0, reach_m=line.length_m)
        self._braking = None

    def hold(self, brake_mps2: float | None = None) -> None:
        """Brake to a stop along the current path and stay stopped.

        `brake_mps2` is the deceleration; None applies the pedal position that also holds the ego at rest.
        """
        self._keep_plan()
        self._braking = Braking(brake_mps2, _speed(self.vehicle))

    def release(self) -> None:
        """Return control to the agent. It continues at the nearest point of its plan that is ahead."""
        was_directed = self._is_directed
        self._line, self._braking, self._ignore = None, None, frozenset()
        if was_directed:
            replace_plan(self._planner, self._plan_ahead())
        self._remaining_plan = []

    def run_step(self) -> Any:
        """Return this tick's `carla.VehicleControl`, not applied."""
        if self._braking is not None:
            return self._brake(self._braking)
        if self._line is not None:
            return self._back_up(self._line) if self._reverse else self._drive_path(self._line)
        if not (plan_of(self._planner) if self._plan_extender is None else self._plan_extender.top_up()):
            # Every copy of the agent raises an error without a plan.
            return self._carla.VehicleControl(throttle=0.0, brake=HOLD_BRAKE)
        return self.agent.run_step()

    # ---- parts

    def _keep_plan(self) -> None:
        """Save the rest of the agent's plan before the first directive replaces it."""
        if not self._is_directed:
            self._remaining_plan = plan_of(self._planner)

    def _plan_ahead(self) -> list[tuple[Any, Any]]:
        """Return the rest of the saved plan, from the first waypoint more than `REJOIN_M` ahead of the ego."""
        here = self.vehicle.get_location()
        away = [here.distance(waypoint.transform.location) for waypoint, _ in self._remaining_plan]
        if not away:
            return []
        nearest = away.index(min(away))
        ahead = (i for i in range(nearest, len(away)) if away[i] > REJOIN_M and self._is_ahead(i))
        # Without one, the ego stops at the end of the plan. If it keeps going, the plan is dropped.
        first = next(ahead, len(away) - 1 if self._plan_extender is None else len(away))
        return self._remaining_plan[first:]

    def _is_ahead(self, index: int) -> bool:
        transform = self._remaining_plan[index][0].transform
        here, along = self.vehicle.get_location(), transform.get_forward_vector()
        ahead = (transform.location.x - here.x) * along.x + (transform.location.y - here.y) * along.y
        return float(ahead) > 0.0

    def _drive_path(self, line: PathLine) -> Any:
        transform = self.vehicle.get_transform()
        here = transform.location
        speed = _speed(self.vehicle)
        self._s = line.project(here.x, here.y, self._s)
        wanted_mps = self._allowed_mps(line, here, speed)
        self._planner.set_speed(3.6 * wanted_mps)
        control = self._steer(line, here, speed)
        if wanted_mps < STOPPED_MPS or speed > wanted_mps + 1.5:
            control.throttle, control.brake = 0.0, max(float(control.brake), HOLD_BRAKE)
        return control

    def _brake(self, braking: Braking) -> Any:
        """Brake. While the ego is moving, steer it along its path or plan, because the guard checked the stop there."""
        speed, line = _speed(self.vehicle), self._line
        pedal = braking.step(speed, self._world.get_snapshot().timestamp.delta_seconds or TICK_S)
        control = self._carla.VehicleControl()
        if speed > STOPPED_MPS and line is not None and not self._reverse:
            here = self.vehicle.get_location()
            self._s = line.project(here.x, here.y, self._s)
            control = self._steer(line, here, speed)
        elif speed > STOPPED_MPS and line is None and plan_of(self._planner):
            control = self._planner.run_step()
        control.throttle, control.brake = 0.0, pedal
        return control

    def _steer(self, line: PathLine, here: Any, speed: float) -> Any:
        """Return the agent's control toward the path. Its controllers get one point of the path."""
        x, y, yaw = line.at(self._s + LOOK_AHEAD_M + LOOK_AHEAD_S * speed)
        # The point is shifted to the other side by the ego's offset, because the controller alone corrects it too late.
        off = line.lateral_m(here.x, here.y, self._s)
        x, y = x + off * math.sin(yaw), y - off * math.cos(yaw)
        place = self._carla.Location(x=x, y=y, z=here.z)
        target = Target(self._carla.Transform(place, self._carla.Rotation(yaw=math.degrees(yaw))))
        replace_plan(self._planner, [(target, self._lane_follow)])
        return self._planner.run_step()

    def _allowed_mps(self, line: PathLine, here: Any, speed: float) -> float:
        """Return the speed that the path and the obstacles in it allow (m/s)."""
        reach = STOP_GAP_M + speed * speed / (2.0 * BRAKING_MPS2) + 4.0
        reach = min(reach, max(line.length_m - self._s, 0.0) + STOP_GAP_M)
        around = self._bodies.near(here.x, here.y, reach + 12.0)
        free = free_way_m(line, self._s, reach, self._half_size, here.z, around, self._ignore, self._reverse)
        gap = math.sqrt(2.0 * BRAKING_MPS2 * max(free - STOP_GAP_M, 0.0)) if free < math.inf else math.inf
        return min(line.bound_at(self._s, BRAKING_MPS2), gap)

    def _back_up(self, line: PathLine) -> Any:
        transform = self.vehicle.get_transform()
        here, speed = transform.location, _speed(self.vehicle)
        self._s = line.project(here.x, here.y, self._s)
        wanted_mps = self._allowed_mps(line, here, speed)
        yaw = math.radians(transform.rotation.yaw)
        x, y, _ = line.at(self._s + BACK_REACH_M)
        # Pure pursuit: the rear axle moves on an arc from its position to the point behind it.
        half = WHEEL_BASE_M / 2.0
        dx, dy = x - (here.x - half * math.cos(yaw)), y - (here.y - half * math.sin(yaw))
        along, aside = dx * math.cos(yaw) + dy * math.sin(yaw), dy * math.cos(yaw) - dx * math.sin(yaw)
        bend = 2.0 * aside / max(along * along + aside * aside, 0.5)
        steer = math.atan(bend * WHEEL_BASE_M) / WHEEL_LOCK_RAD
        control = self._carla.VehicleControl(steer=min(max(steer, -0.8), 0.8), reverse=True)
        velocity = self.vehicle.get_velocity()
        rolls_ahead = velocity.x * math.cos(yaw) + velocity.y * math.sin(yaw) > STOPPED_MPS
        if rolls_ahead or wanted_mps < STOPPED_MPS or speed > wanted_mps + 0.5:
            control.throttle, control.brake = 0.0, HOLD_BRAKE
        else:
            control.throttle = min(max(0.25 + 0.5 * (wanted_mps - speed), 0.0), 0.6)
        return control


def densified_route(plan: Sequence[tuple[Any, Any]]) -> list[AgentRoutePoint]:
    """Return a plan with a waypoint about every meter, along the lanes."""
    route: list[AgentRoutePoint] = []
    for waypoint, option in plan:
        command = command_of(option)
        if route:
            route.extend(_waypoints_between(route[-1].waypoint, waypoint, command))
        route.append(AgentRoutePoint(waypoint, command))
    return route


def _waypoints_between(start: Any, end: Any, command: str) -> list[AgentRoutePoint]:
    points: list[AgentRoutePoint] = []
    goal = end.transform.location
    remaining_m = start.transform.location.distance(goal)
    here = start
    while remaining_m > MAX_SPACING_M:
        next_waypoints = here.next(1.0)
        if not next_waypoints:
            break
        here = min(next_waypoints, key=lambda w: w.transform.location.distance(goal))
        distance_m = here.transform.location.distance(goal)
        # A lane that comes hardly nearer to the goal does not lead there.
        if distance_m >= remaining_m - 0.3:
            break
        remaining_m = distance_m
        points.append(AgentRoutePoint(here, command))
    return points


def command_of(option: Any) -> str:
    """Return the command of an `AgentRoutePoint` for a `RoadOption` of CARLA's agents."""
    name = str(getattr(option, "name", option)).lower()
    return {"lanefollow": "lane_follow", "changelaneleft": "change_left", "changelaneright": "change_right"}.get(
        name, name
    )


def _road_option(options: Any, option: Any) -> Any:
    """Return the `RoadOption` for a command. A `RoadOption` is returned unchanged."""
    if not isinstance(option, str):
        return option
    return next((item for item in options if command_of(item) == option), options.LANEFOLLOW)


def _speed(vehicle: Any) -> float:
    velocity = vehicle.get_velocity()
    return math.hypot(velocity.x, velocity.y)
