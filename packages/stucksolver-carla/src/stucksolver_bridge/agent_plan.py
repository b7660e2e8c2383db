"""Creates BehaviorAgents from any copy of CARLA's `agents`, and keeps their plans from running out.

Public copies of `agents` differ in their constructors' arguments, in whether the local planner exposes its plan, and in
how early it drops the last waypoint. All of them raise an error on the tick after that. So a plan must be longer than
the run. Python 3.7, standard library only.
"""

from __future__ import annotations

import inspect
import math
from typing import Any, Sequence

from stucksolver_bridge.traffic_side import inner_lane

LAST_M = 2.0
"""Distance to the last waypoint at which the plan is extended (m). Most copies drop the last waypoint at 1 m. An
earlier extension would be worse: the agent steers straight at its last waypoint, and cuts a bend at the end more if
others follow it. Ours."""
AHEAD_M = 25.0
"""Length of an extended plan ahead of the ego (m). This is more than any copy of the planner drops at once: the
waypoints within 3 m plus half a second of travel."""
STEP_M = 1.0
"""Distance between added waypoints, as in the leaderboard's own plans."""
FORK_M = 8.0
"""Distance into a junction at which the lanes through it have separated (m). Ours."""
ON_ROUTE_M = 2.0
"""Maximum distance between the plan's end and the nearest point of the route for a plan that ends on the route (m).
Ours."""
STATION_BACK, STATION_AHEAD = 5, 30
"""Numbers of route points before and after the last station among which the next one is searched. The search is
local because a route may cross itself. Ours."""

Plan = Sequence[Any]
"""Pairs of a `carla.Waypoint` and a `RoadOption`."""


class AgentsError(TypeError):
    """A copy of CARLA's `agents` lacks a method that is used here. The message names it."""


def make_agent(agent_class: Any, vehicle: Any, behavior: str, carla_map: Any) -> Any:
    """Create a `BehaviorAgent` from any copy. Copies of 0.9.14 and later get the map, which saves a call.

    Raises:
        AgentsError: The copy is older than 0.9.12.
    """
    parameters = inspect.signature(agent_class.__init__).parameters
    arguments = {"map_inst": carla_map} if "map_inst" in parameters else {}
    agent = agent_class(vehicle, behavior=behavior, **arguments)
    check_agent(agent)
    return agent


def check_agent(agent: Any) -> None:
    """Check that an agent has the methods that the bridge uses.

    Raises:
        AgentsError: A method is missing.
    """
    planner = agent.get_local_planner() if hasattr(agent, "get_local_planner") else None
    missing = [name for name in ("get_local_planner", "set_global_plan", "trace_route") if not hasattr(agent, name)]
    if planner is not None and not (hasattr(planner, "get_plan") or hasattr(planner, "_waypoints_queue")):
        missing.append("get_plan")
    if missing:
        file = inspect.getfile(type(agent))
        raise AgentsError(
            f"the BehaviorAgent of {file} has no {missing[0]}; use CARLA's `agents` of 0.9.12 or later, or an agent "
            "with the same methods"
        )


def plan_of(planner: Any) -> list[Any]:
    """Return the remaining plan of a local planner."""
    # `get_plan` came with 0.9.13.
    remaining = planner.get_plan() if hasattr(planner, "get_plan") else planner._waypoints_queue
    return list(remaining)


def replace_plan(planner: Any, plan: Plan) -> None:
    """Replace a local planner's whole plan by another one."""
    planner.set_global_plan(list(plan), stop_waypoint_creation=True, clean_queue=True)


class PlanExtender:
    """Extends a local planner's plan with the rest of the route, and with the lane ahead beyond the route's end.

    `lane_follow`: the road option of the added points.
    """

    def __init__(self, planner: Any, vehicle: Any, carla_map: Any, lane_follow: Any) -> None:
        self._planner = planner
        self._vehicle = vehicle
        self._map = carla_map
        self._lane_follow = lane_follow
        self._route: Sequence[Any] = ()
        self._options: Sequence[Any] = ()
        self._station = 0

    def set_route(self, plan: Plan) -> None:
        """Use another route: pairs of waypoint and road option about a meter apart."""
        self._route = [waypoint for waypoint, _ in plan]
        self._options = [option for _, option in plan]
        self._station = 0

    def top_up(self) -> bool:
        """Extend the plan if it is about to run out. Call this before each step of the agent.

        A copy that drops its last waypoint before `LAST_M` brakes for one tick, and continues with the extended plan.

        Returns:
            False if the plan is empty and the road ends here.
        """
        here = self._vehicle.get_location()
        self._advance(here)
        remaining = plan_of(self._planner)
        if len(remaining) > 1 or (remaining and remaining[0][0].transform.location.distance(here) >= LAST_M):
            return True
        added = self._rest_of_route(remaining, here)
        last = added[-1][0] if added else remaining[-1][0] if remaining else self._own_lane(here)
        added += self._lane_ahead(last, here)
        if added:
            self._planner.set_global_plan(added, stop_waypoint_creation=True, clean_queue=False)
        return bool(remaining or added)

    def _advance(self, here: Any) -> None:
        """Update the index of the nearest route point."""
        first = max(self._station - STATION_BACK, 0)
        near = range(first, min(self._station + STATION_AHEAD, len(self._route)))
        if near:
            self._station = min(near, key=lambda i: float(self._route[i].transform.location.distance(here)))

    def _rest_of_route(self, remaining: Plan, here: Any) -> list[Any]:
        """Return the route beyond the plan's end. CARLA's agent discards it when it changes lanes for a tailgater."""
        if not self._route:
            return []
        end = remaining[-1][0].transform.location if remaining else here
        ahead = range(self._station, len(self._route))
        nearest = min(ahead, key=lambda i: float(self._route[i].transform.location.distance(end)))
        if remaining and self._route[nearest].transform.location.distance(end) > ON_ROUTE_M:
            return []
        return list(zip(self._route[nearest + 1 :], self._options[nearest + 1 :]))

    def _own_lane(self, here: Any) -> Any:
        """Return the ego's lane; if that is an oncoming lane, the adjacent one in the ego's direction."""
        waypoint = self._map.get_waypoint(here)
        yaw = self._vehicle.get_transform().rotation.yaw
        if waypoint is not None and turn_deg(waypoint, yaw) > 90.0:
            waypoint = inner_lane(waypoint) or waypoint
        return waypoint

    def _lane_ahead(self, last: Any, here: Any) -> list[Any]:
        """Return waypoints of the lane beyond `last`, straight on at forks, until the plan is long enough."""
        waypoints: list[Any] = []
        while last is not None and last.transform.location.distance(here) < AHEAD_M and len(waypoints) < 2 * AHEAD_M:
            last = straightest(last)
            if last is not None:
                waypoints.append((last, self._lane_follow))
        return waypoints


def straightest(waypoint: Any) -> Any:
    """Return the waypoint one meter ahead, at a fork on the branch that turns least; None if the lane ends."""
    branches = waypoint.next(STEP_M)
    if len(branches) < 2:
        return branches[0] if branches else None
    yaw = waypoint.transform.rotation.yaw
    return min(branches, key=lambda branch: min((turn_deg(w, yaw) for w in branch.next(FORK_M)), default=180.0))


def turn_deg(waypoint: Any, yaw_deg: float) -> float:
    """Return the difference between a waypoint's direction and a heading (degrees)."""
    return abs(math.remainder(float(waypoint.transform.rotation.yaw) - yaw_deg, 360.0))
