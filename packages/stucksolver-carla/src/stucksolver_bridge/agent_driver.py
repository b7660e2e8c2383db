"""CARLA's own BehaviorAgent (`agents.navigation`, 0.9.12 and later) as a driver that can follow a given path.

The agent is not changed. It decides by itself unless a path is given. Then its local planner and its controllers drive
that path, and its decisions are suspended until `release`. It cannot reverse, so this file steers when backing up.
Python 3.7, standard library only; `carla` is passed in.
"""

from __future__ import annotations

import math
from typing import Any, Callable, Collection, Iterable, NamedTuple, Sequence

from stucksolver_bridge.actor_boxes import ActorBoxes
from stucksolver_bridge.agent_plan import PlanExtender, check_agent, plan_of, replace_plan
from stucksolver_bridge.braking import STAND_BRAKE, STANDING_MPS, Braking
from stucksolver_bridge.clearance import free_way_m
from stucksolver_bridge.obstacle_exposure import ObstacleExposingWorld, props_around
from stucksolver_bridge.path_line import PathLine

LOOK_AHEAD_M, LOOK_AHEAD_S = 2.8, 0.45
"""The controllers steer toward a point this far ahead of the vehicle's center."""
BRAKING_MPS2 = 3.0
KEPT_M = 1.2
"""Distance kept to an obstacle in the path."""
TICK_S = 0.05
FILL_M = 1.5
"""If two waypoints of a plan are farther apart than this, others are added between them."""
REJOIN_M = 5.0
BACK_REACH_M = 3.0
WHEEL_BASE_M, WHEEL_LOCK_RAD = 2.9, 1.22
"""Values of most cars in CARLA (70 degrees of lock). For a car with other values, backing up corrects itself."""


class AgentRoutePoint(NamedTuple):
    """A `carla.Waypoint` of the route and the maneuver there (`lane_follow`, `left`, `change_left`, ...)."""

    waypoint: Any
    command: str


class Target:
    """The point toward which the local planner steers; the planner reads only a waypoint's transform."""

    is_junction = False

    def __init__(self, transform: Any) -> None:
        self.transform = transform


class AgentDriver:
    """A BehaviorAgent that can follow a given path.

    Args:
        agent: The BehaviorAgent.
        carla: The `carla` module.
        obstacles: If True, the agent sees the stationary objects of the client's ground truth. If False, it sees only
            what it looks for by itself. A function returns the perceived obstacles (see `ObstacleExposingWorld`).
        keeps_going: If True, the vehicle continues along the lane beyond the end of its plan, until the caller ends the
            drive. An evaluator does so some meters before or after that point. If False, the vehicle stops there.

    Raises:
        AgentsError: This copy of the `agents` package cannot be driven.
    """

    acceleration_mps2 = 3.5
    """Highest acceleration from rest: a sedan's at three quarters of full throttle, measured on carlette."""

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
            self._show(source)
        self._bodies = ActorBoxes(self._world, self.vehicle.id)
        box = self.vehicle.bounding_box.extent
        self._half_size = (float(box.x), float(box.y))
        self._left: list[tuple[Any, Any]] = []
        self._line: PathLine | None = None
        self._s = 0.0
        self._reverse = False
        self._ignore: frozenset[int] = frozenset()
        self._holding: Braking | None = None
        self._route: list[AgentRoutePoint] = []
        keeper = PlanExtender(self._planner, self.vehicle, self._map, self._lane_follow)
        self._keeper = keeper if keeps_going else None
        self.note_plan()

    def _show(self, source: Callable[[], Iterable[Any]]) -> None:
        if not isinstance(self.agent._world, ObstacleExposingWorld):
            self.agent._world = ObstacleExposingWorld(self.agent._world, self.vehicle, source)

    # ---- the route

    @property
    def route(self) -> Sequence[Any]:
        """The whole route as `AgentRoutePoint`s, about one per meter."""
        return self._route

    def note_plan(self) -> None:
        """Read the route again, because the agent's local planner has a new plan."""
        self._take_route(plan_of(self._planner))

    def set_destination(self, destination: Any, start: Any | None = None) -> None:
        """Plan a route to a `carla.Location` with the agent's own planner; it starts at the vehicle by default."""
        begin = self._map.get_waypoint(self.vehicle.get_location() if start is None else start)
        self.set_plan(self.agent.trace_route(begin, self._map.get_waypoint(destination)))

    def set_plan(self, plan: Sequence[tuple[Any, Any]]) -> None:
        """Drive a plan: pairs of a waypoint and a road option, or our name for the option.

        Raises:
            ValueError: The plan has fewer than two points.
        """
        options = type(self._lane_follow)
        plan = [(waypoint, _option(options, option)) for waypoint, option in plan]
        if len(plan) < 2:
            raise ValueError("a plan needs two waypoints; use hold() to stand still")
        plan = [*self._way_to(plan[0][0]), *plan]
        replace_plan(self._planner, plan)
        self._line, self._holding = None, None
        self._left = []
        self._take_route(plan)

    def _way_to(self, first: Any) -> list[tuple[Any, Any]]:
        """Return the lane from the vehicle to the start of a plan farther ahead in it; empty if it is elsewhere.

        The agent looks for obstacles in the lane of a waypoint a few places ahead in its plan. Without this piece of
        lane, that waypoint may already be in another lane while the vehicle is still behind an obstacle.
        """
        here = self._map.get_waypoint(self.vehicle.get_location())
        if here is None or here.transform.location.distance(first.transform.location) < REJOIN_M:
            return []
        way = _between(here, first, "lane_follow")
        last = way[-1].waypoint.transform.location if way else here.transform.location
        arrives = last.distance(first.transform.location) < 2.0 * FILL_M
        return [(point.waypoint, self._lane_follow) for point in way] if arrives else []

    def _take_route(self, plan: Sequence[tuple[Any, Any]]) -> None:
        self._route = filled(plan) if len(plan) > 1 else []
        if self._keeper is not None:
            self._keeper.take_route(plan)

    @property
    def path_left_m(self) -> float:
        """Remaining length of the given path (m); 0 if there is none."""
        return 0.0 if self._line is None else max(self._line.length_m - self._s, 0.0)

    def done(self) -> bool:
        """True if the agent has finished its route; False while it follows a given path or holds."""
        return False if self._told else bool(self.agent.done())

    @property
    def _told(self) -> bool:
        return self._line is not None or self._holding is not None

    # ---- orders

    def follow(self, path: Sequence[Any], reverse: bool = False, ignore: Collection[int] = frozenset()) -> None:
        """Drive a path of (x, y, speed bound) in CARLA's world from the next step on; brake for obstacles in it."""
        line = PathLine(path)
        self._take_over()
        place = self.vehicle.get_location()
        self._line, self._reverse, self._ignore = line, reverse, frozenset(ignore)
        self._s = line.project(place.x, place.y, 0.0, reach_m=line.length_m)
        self._holding = None

    def hold(self, brake_mps2: float | None = None) -> None:
        """Brake to a stop along the current path and stay stopped; a `brake_mps2` of None brakes as usual."""
        self._take_over()
        self._holding = Braking(brake_mps2, _speed(self.vehicle))

    def release(self) -> None:
        """Let the agent decide again. It continues at the nearest point of its plan that is ahead."""
        told = self._told
        self._line, self._holding, self._ignore = None, None, frozenset()
        if told:
            replace_plan(self._planner, self._ahead())
        self._left = []

    def run_step(self) -> Any:
        """Return this tick's `carla.VehicleControl`, not applied."""
        if self._holding is not None:
            return self._stopping(self._holding)
        if self._line is not None:
            return self._backwards(self._line) if self._reverse else self._forwards(self._line)
        if not (plan_of(self._planner) if self._keeper is None else self._keeper.top_up()):
            # Every copy of the agent fails without a plan.
            return self._carla.VehicleControl(throttle=0.0, brake=STAND_BRAKE)
        return self.agent.run_step()

    # ---- parts

    def _take_over(self) -> None:
        """Keep the rest of the agent's plan when the first order comes."""
        if not self._told:
            self._left = plan_of(self._planner)

    def _ahead(self) -> list[tuple[Any, Any]]:
        """Return the rest of the plan from a little ahead of the vehicle on."""
        here = self.vehicle.get_location()
        away = [here.distance(waypoint.transform.location) for waypoint, _ in self._left]
        if not away:
            return []
        nearest = away.index(min(away))
        ahead = (i for i in range(nearest, len(away)) if away[i] > REJOIN_M and self._is_ahead(i))
        # If there is none, the vehicle stops at the end of the plan or, if it keeps going, leaves the plan behind.
        first = next(ahead, len(away) - 1 if self._keeper is None else len(away))
        return self._left[first:]

    def _is_ahead(self, index: int) -> bool:
        transform = self._left[index][0].transform
        here, along = self.vehicle.get_location(), transform.get_forward_vector()
        ahead = (transform.location.x - here.x) * along.x + (transform.location.y - here.y) * along.y
        return float(ahead) > 0.0

    def _forwards(self, line: PathLine) -> Any:
        transform = self.vehicle.get_transform()
        here = transform.location
        speed = _speed(self.vehicle)
        self._s = line.project(here.x, here.y, self._s)
        wanted = self._allowed(line, here, speed)
        self._planner.set_speed(3.6 * wanted)
        control = self._steered(line, here, speed)
        if wanted < STANDING_MPS or speed > wanted + 1.5:
            control.throttle, control.brake = 0.0, max(float(control.brake), STAND_BRAKE)
        return control

    def _stopping(self, braking: Braking) -> Any:
        """Brake. While the vehicle is moving, steer it along its path or plan: the stop was proven along that."""
        speed, line = _speed(self.vehicle), self._line
        pedal = braking.step(speed, self._world.get_snapshot().timestamp.delta_seconds or TICK_S)
        control = self._carla.VehicleControl()
        if speed > STANDING_MPS and line is not None and not self._reverse:
            here = self.vehicle.get_location()
            self._s = line.project(here.x, here.y, self._s)
            control = self._steered(line, here, speed)
        elif speed > STANDING_MPS and line is None and plan_of(self._planner):
            control = self._planner.run_step()
        control.throttle, control.brake = 0.0, pedal
        return control

    def _steered(self, line: PathLine, here: Any, speed: float) -> Any:
        """Return the agent's control for driving back to the path. Its controllers see one point of the path."""
        x, y, yaw = line.at(self._s + LOOK_AHEAD_M + LOOK_AHEAD_S * speed)
        # The point is moved to the other side by the vehicle's offset: the controller alone corrects the offset late.
        off = line.beside(here.x, here.y, self._s)
        x, y = x + off * math.sin(yaw), y - off * math.cos(yaw)
        place = self._carla.Location(x=x, y=y, z=here.z)
        target = Target(self._carla.Transform(place, self._carla.Rotation(yaw=math.degrees(yaw))))
        replace_plan(self._planner, [(target, self._lane_follow)])
        return self._planner.run_step()

    def _allowed(self, line: PathLine, here: Any, speed: float) -> float:
        """Return the speed that the path and the obstacles in it allow (m/s)."""
        reach = KEPT_M + speed * speed / (2.0 * BRAKING_MPS2) + 4.0
        reach = min(reach, max(line.length_m - self._s, 0.0) + KEPT_M)
        around = self._bodies.near(here.x, here.y, reach + 12.0)
        free = free_way_m(line, self._s, reach, self._half_size, here.z, around, self._ignore, self._reverse)
        gap = math.sqrt(2.0 * BRAKING_MPS2 * max(free - KEPT_M, 0.0)) if free < math.inf else math.inf
        return min(line.bound_at(self._s, BRAKING_MPS2), gap)

    def _backwards(self, line: PathLine) -> Any:
        transform = self.vehicle.get_transform()
        here, speed = transform.location, _speed(self.vehicle)
        self._s = line.project(here.x, here.y, self._s)
        wanted = self._allowed(line, here, speed)
        yaw = math.radians(transform.rotation.yaw)
        x, y, _ = line.at(self._s + BACK_REACH_M)
        # The rear axle moves on an arc from its position to the point behind it.
        half = WHEEL_BASE_M / 2.0
        dx, dy = x - (here.x - half * math.cos(yaw)), y - (here.y - half * math.sin(yaw))
        along, aside = dx * math.cos(yaw) + dy * math.sin(yaw), dy * math.cos(yaw) - dx * math.sin(yaw)
        bend = 2.0 * aside / max(along * along + aside * aside, 0.5)
        steer = math.atan(bend * WHEEL_BASE_M) / WHEEL_LOCK_RAD
        control = self._carla.VehicleControl(steer=min(max(steer, -0.8), 0.8), reverse=True)
        velocity = self.vehicle.get_velocity()
        rolls_on = velocity.x * math.cos(yaw) + velocity.y * math.sin(yaw) > STANDING_MPS
        if rolls_on or wanted < STANDING_MPS or speed > wanted + 0.5:
            control.throttle, control.brake = 0.0, STAND_BRAKE
        else:
            control.throttle = min(max(0.25 + 0.5 * (wanted - speed), 0.0), 0.6)
        return control


def filled(plan: Sequence[tuple[Any, Any]]) -> list[AgentRoutePoint]:
    """Return a plan with a waypoint about every meter, along the lanes."""
    route: list[AgentRoutePoint] = []
    for waypoint, option in plan:
        command = command_of(option)
        if route:
            route.extend(_between(route[-1].waypoint, waypoint, command))
        route.append(AgentRoutePoint(waypoint, command))
    return route


def _between(start: Any, end: Any, command: str) -> list[AgentRoutePoint]:
    found: list[AgentRoutePoint] = []
    goal = end.transform.location
    left = start.transform.location.distance(goal)
    here = start
    while left > FILL_M:
        onward = here.next(1.0)
        if not onward:
            break
        here = min(onward, key=lambda w: w.transform.location.distance(goal))
        now = here.transform.location.distance(goal)
        if now >= left - 0.3:
            break
        left = now
        found.append(AgentRoutePoint(here, command))
    return found


def command_of(option: Any) -> str:
    """Return our name for a `RoadOption` of CARLA's agents."""
    name = str(getattr(option, "name", option)).lower()
    return {"lanefollow": "lane_follow", "changelaneleft": "change_left", "changelaneright": "change_right"}.get(
        name, name
    )


def _option(options: Any, option: Any) -> Any:
    """Return the agents' road option for our name of it. One of theirs is returned unchanged."""
    if not isinstance(option, str):
        return option
    return next((item for item in options if command_of(item) == option), options.LANEFOLLOW)


def _speed(vehicle: Any) -> float:
    velocity = vehicle.get_velocity()
    return math.hypot(velocity.x, velocity.y)
