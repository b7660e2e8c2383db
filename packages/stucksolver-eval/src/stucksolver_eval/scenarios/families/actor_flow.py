"""Flows of cars whose start and end are given in the route file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import carla

from stucksolver_carla.drivers.behavior import RouteError, trace_route
from stucksolver_eval.background_traffic.lanes import adjacent_lane
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.vehicle_flow import Flow, run_flows
from stucksolver_eval.scenarios.parameters import LocationParameter, NumberParameter, RangeParameter
from stucksolver_eval.scenarios.scenario import Scenario, ScenarioError

SINK_M = 2.0
"""Distance from the end of a flow at which its cars are removed (m). As in scenario_runner."""
MOST_LANES = 4
"""Maximum number of lanes on one side. Ours."""


class ActorFlow(Scenario):
    """Base: cars flow from `start_actor_flow` to `end_actor_flow` at constant speed, independently of the hero."""

    start_at = LocationParameter("start_actor_flow", None)
    end_at = LocationParameter("end_actor_flow", None)
    flow_mps = NumberParameter("flow_speed", 10.0, "m/s")
    gaps_m = RangeParameter("source_dist_interval", (5.0, 7.0), "m")
    all_lanes = True
    """True for one flow in each lane of that direction, not only in the specified one."""
    lane_type: Any = carla.LaneType.Driving
    prefilled = True

    def needs(self, setting: ScenarioContext) -> str | None:
        self.lines()
        return None

    def stage(self) -> None:
        """Do nothing. Cars that start now would be far away at the time of the trigger."""

    def script(self) -> Iterator[None]:
        self.clear_way()
        flows = [Flow(self, line, self.flow_mps, self.gaps_m, kinds=self.kinds()) for line in self.lines()]
        if self.prefilled:
            for flow in flows:
                flow.fill()
        yield from run_flows(flows, self.over())
        self.restore_way()

    def kinds(self) -> tuple[str, ...]:
        """Return the blueprints to draw from."""
        return self.cast.car_kinds

    def clear_way(self) -> None:
        """Remove background traffic from the roads of the flow."""
        self.traffic.change_opposite_behavior(active=False)
        self.traffic.switch_route_sources(False)
        ends = [line[0] for line in self.lines()] + [line[-1] for line in self.lines()]
        self.traffic.handle_junction_scenario(remove_entries=ends, stop_entries=True)

    def restore_way(self) -> None:
        """Allow background traffic again."""
        self.traffic.change_opposite_behavior(active=True)
        self.traffic.switch_route_sources(True)

    def over(self) -> Callable[[], bool]:
        """Return a check for whether the hero has reached or passed the end of a lane of the flow."""
        ends = [line[-1].transform.location for line in self.lines()]
        route = self.setting.route
        end_s = min(float(route.s_m[route.project(ends[0], self.trigger_index)]), route.length_m - 3.0)

        def arrived() -> bool:
            hero = self.hero
            return self.setting.hero_s_m >= end_s or any(hero.distance_m(e.x, e.y) < SINK_M for e in ends)

        return arrived

    def lines(self) -> list[list[Any]]:
        """Return the waypoints of each lane. Raises `ScenarioError` if start or end are missing or not on a lane."""
        if not hasattr(self, "_lines"):
            self._lines = self._traced()
        return self._lines

    def _traced(self) -> list[list[Any]]:
        start, end = self._waypoint("start_actor_flow", self.start_at), self._waypoint("end_actor_flow", self.end_at)
        found = [self._line(start, end)]
        if self.all_lanes:
            for slot in [k for k in range(-MOST_LANES, MOST_LANES + 1) if k]:
                first, second = adjacent_lane(start, slot), adjacent_lane(end, slot)
                if first is not None and second is not None:
                    found.append(self._line(first, second))
        return found

    def _line(self, start: Any, end: Any) -> list[Any]:
        if self.lane_type != carla.LaneType.Driving:
            return _along_lane(start, end)
        try:
            points = trace_route(self.setting.map, start.transform.location, end.transform.location)
        except RouteError as error:
            raise ScenarioError(f"{self.spec.name}: there is no path for the actor flow: {error}") from error
        return [point.waypoint for point in points[::2]] + [points[-1].waypoint]

    def _waypoint(self, name: str, place: tuple[float, float, float] | None) -> Any:
        if place is None:
            raise ScenarioError(f'{self.spec.name}: <{name}> is missing; write <{name} x="..." y="..." z="..."/>')
        waypoint = self.setting.map.get_waypoint(carla.Location(*place), lane_type=self.lane_type)
        if waypoint is None:
            raise ScenarioError(f"{self.spec.name}: <{name}> is not on a {self.lane_type} lane; move it onto one")
        return waypoint


def _along_lane(start: Any, end: Any) -> list[Any]:
    """Return waypoints along lanes that the route planner does not cover, up to the point nearest to `end`."""
    line, goal = [start], end.transform.location
    for _ in range(200):
        after = line[-1].next(2.0)
        if not after:
            break
        best = min(after, key=lambda item: item.transform.location.distance(goal))
        near = line[-1].transform.location.distance(goal)
        if near < 4.0 and best.transform.location.distance(goal) > near:
            break
        line.append(best)
    return line
