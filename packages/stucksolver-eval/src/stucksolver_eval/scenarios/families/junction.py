"""The next junction on the route: its other entries and its traffic lights."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import carla

from stucksolver_bridge.traffic_side import drives_on_left
from stucksolver_eval.background_traffic.lanes import RouteJunction, entries, route_junctions
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.lane_places import run_of_lane, turn_deg, upstream, way_turn_deg
from stucksolver_eval.scenarios.scenario import Scenario

FROZEN = {"green": carla.TrafficLightState.Green, "red": carla.TrafficLightState.Red}


class JunctionScenario(Scenario):
    """A scenario at the route's next junction after the trigger."""

    needs_map = "a junction on the route after the trigger point"

    def needs(self, setting: ScenarioContext) -> str | None:
        if self._found is None:
            return "the route has no junction after the trigger point"
        return None

    @cached_property
    def _found(self) -> RouteJunction | None:
        return next(
            (junction for junction in route_junctions(self.setting.route) if junction.last >= self.trigger_index), None
        )

    @cached_property
    def junction(self) -> RouteJunction:
        """The junction that `needs` found."""
        assert self._found is not None, "needs() was not called"
        return self._found

    @cached_property
    def entry(self) -> carla.Waypoint:
        """The route's last waypoint before the junction."""
        return self.setting.route.waypoints[max(self.junction.first - 1, 0)]

    @cached_property
    def exit(self) -> carla.Waypoint:
        """The route's first waypoint after the junction."""
        route = self.setting.route
        return route.waypoints[min(self.junction.last + 1, len(route.waypoints) - 1)]

    @cached_property
    def entry_s(self) -> float:
        """Arc length at which the route enters the junction (m)."""
        return float(self.setting.route.s_m[self.junction.first])

    @cached_property
    def exit_s(self) -> float:
        """Arc length at which the route leaves the junction (m)."""
        return float(self.setting.route.s_m[self.junction.last])

    @cached_property
    def turn(self) -> str:
        """The hero's turn: `left`, `right` or `straight`; left and right are swapped in left-hand traffic."""
        angle = -turn_deg(self.entry, self.exit) if drives_on_left(self.entry) else turn_deg(self.entry, self.exit)
        return "straight" if abs(angle) < 35.0 else "right" if angle > 0 else "left"

    def entries_from(self, side: str) -> list[carla.Waypoint]:
        """Return the last waypoints of the lanes that enter from a side: `left`, `right` or `opposite`."""
        inside = self.setting.route.waypoints[self.junction.first]
        others = [entry for entry in entries(inside) if entry.road_id != self.entry.road_id]
        return [other for other in others if _comes_from(self.entry, other) == side]

    def passes_exit(self) -> bool:
        """Return True if the hero has left the junction."""
        return self.setting.hero_s_m > self.exit_s

    def approach(
        self,
        entry: carla.Waypoint,
        before_m: float,
        after_m: float,
        ways: Callable[[carla.Waypoint, carla.Waypoint], float],
    ) -> list[carla.Waypoint]:
        """Return waypoints of a path through the junction.

        Args:
            entry: The last waypoint before the junction.
            before_m: Distance before the entry at which the path starts.
            after_m: Distance after the junction at which the path ends.
            ways: `ways(entry, first)` rates the lane of the junction that starts at `first`. The lowest rating wins.
        """
        start = upstream(entry, before_m)
        distance = start.transform.location.distance(entry.transform.location)
        line = [w for w in run_of_lane(start, distance + 2.0) if not w.is_junction] or [entry]
        while True:
            after = line[-1].next(2.0)
            if not after:
                return line
            line.append(min(after, key=lambda item: ways(entry, item)) if len(after) > 1 else after[0])
            if line[-1].is_junction:
                break
        while line[-1].is_junction and (after := line[-1].next(2.0)):
            line.append(after[0])
        return line + run_of_lane(line[-1], after_m)[1:]

    # Traffic lights

    @cached_property
    def lights(self) -> list[carla.TrafficLight]:
        """The traffic lights of the junction."""
        return list(self.setting.world.get_traffic_lights_in_junction(self.junction.number))

    def lights_of(self, roads: set[int]) -> list[carla.TrafficLight]:
        """Return the lights that stop one of these roads. The ids are those of roads outside or inside the junction."""
        return [light for light in self.lights if any(w.road_id in roads for w in light.get_stop_waypoints())]

    @cached_property
    def own_lights(self) -> list[carla.TrafficLight]:
        """The lights that apply to the hero."""
        route = self.setting.route
        inside = {route.waypoints[i].road_id for i in range(self.junction.first, self.junction.last + 1)}
        return self.lights_of({self.entry.road_id}) or self.lights_of(inside)

    def hold_lights(self, green: Sequence[Any]) -> None:
        """Freeze the junction's lights: green for these, red for all others."""
        lucky = {item.id for item in green}
        for light in self.lights:
            light.set_state(FROZEN["green"] if light.id in lucky else FROZEN["red"])
        if self.lights:
            self.lights[0].freeze(True)
        self._held = True

    def free_lights(self) -> None:
        """Unfreeze the lights."""
        if self._held and self.lights:
            self.lights[0].freeze(False)
        self._held = False

    _held = False

    def close(self) -> None:
        self.free_lights()


def straight_way(entry: carla.Waypoint, first: carla.Waypoint) -> float:
    """Rate a lane through a junction by its change of heading (degrees); straight on is best."""
    return abs(way_turn_deg(entry, first))


def way_to(road_id: int, lane_id: int | None = None) -> Callable[[carla.Waypoint, carla.Waypoint], float]:
    """Return a rating of lanes through a junction. The best ones lead to this road, and to `lane_id` if it is set."""

    def rate(entry: carla.Waypoint, first: carla.Waypoint) -> float:
        here = first
        for _ in range(80):
            after = here.next(1.0)
            if not here.is_junction or not after:
                break
            here = after[0]
        wrong = 1000.0 if here.road_id != road_id else 100.0 if lane_id not in (None, here.lane_id) else 0.0
        return wrong + abs(turn_deg(entry, here)) / 10.0

    return rate


def _comes_from(entry: carla.Waypoint, other: carla.Waypoint) -> str:
    """Return the side from which another entry's traffic comes, relative to `entry`; mirrored in left-hand traffic."""
    angle = -turn_deg(entry, other) if drives_on_left(entry) else turn_deg(entry, other)
    if abs(angle) > 135.0:
        return "opposite"
    if abs(angle) < 45.0:
        return "same"
    return "left" if angle > 0 else "right"
