"""CrossingBicycleFlow."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import carla

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.actor_flow import ActorFlow
from stucksolver_eval.scenarios.families.crossing_actors import BICYCLES
from stucksolver_eval.scenarios.families.junction import JunctionScenario
from stucksolver_eval.scenarios.families.lane_places import run_of_lane
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import TURNS, JunctionSites, bicycles
from stucksolver_eval.sites.parameter_draws import flow_values
from stucksolver_eval.sites.suite_placement import SuitePlacement

RED_S = 5.0
"""Duration of the hero's red light (s)."""
LOOK_M = 200.0
"""Length of bicycle lane that is searched (m)."""
BEYOND_M = 40.0
"""Length of the flow beyond the junction (m)."""


@scenario
class CrossingBicycleFlow(ActorFlow, JunctionScenario):
    """The hero turns across a bicycle lane with a flow of bicycles."""

    type = "CrossingBicycleFlow"
    placed = SuitePlacement(
        "bench220", 1060, JunctionSites(TURNS, extra=bicycles), flow_values((8, 12), (5, 15), (25, 30))
    )
    driver_alone = "collision: turns into a bicycle"
    starts = "the bicycles ride from the trigger on; if there are lights, the hero's is red for 5 s, then green"
    needs_map = "a junction on the route, and a bicycle lane from `start_actor_flow` through it"
    blueprints = BICYCLES
    all_lanes = False
    lane_type = carla.LaneType.Biking

    def needs(self, setting: ScenarioContext) -> str | None:
        if self.start_at is not None:
            place = carla.Location(*self.start_at)
            lane = setting.map.get_waypoint(place, project_to_road=True, lane_type=self.lane_type)
            if lane is None or lane.transform.location.distance(place) > 5.0:
                return "there is no bicycle lane at <start_actor_flow>"
        return JunctionScenario.needs(self, setting) or ActorFlow.needs(self, setting)

    def kinds(self) -> tuple[str, ...]:
        return BICYCLES

    def script(self) -> Iterator[None]:
        if self.own_lights:
            self.hold_lights(green=[])
        end_s = self.cast.time_s + RED_S
        for _ in super().script():
            if self.own_lights and self.cast.time_s >= end_s:
                self.hold_lights(green=self.own_lights)
                end_s = float("inf")
            yield
        self.free_lights()

    def _traced(self) -> list[list[Any]]:
        """Return the lane up to `end_actor_flow`, or without it straight on to 40 m beyond the junction."""
        if self.end_at is not None:
            return super()._traced()
        line = run_of_lane(self._waypoint("start_actor_flow", self.start_at), LOOK_M)
        inside = [k for k, waypoint in enumerate(line) if waypoint.is_junction]
        leaves = next((k for k in range(inside[0], len(line)) if not line[k].is_junction), len(line)) if inside else 0
        return [line[: leaves + int(BEYOND_M / 2.0)] if inside else line]

    def over(self) -> Callable[[], bool]:
        return self.passes_exit
