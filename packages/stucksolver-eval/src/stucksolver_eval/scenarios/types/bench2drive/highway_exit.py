"""HighwayExit."""

from __future__ import annotations

from collections.abc import Callable

from stucksolver_eval.background_traffic.lanes import route_junctions
from stucksolver_eval.scenarios.families.actor_flow import ActorFlow
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.motorway_sites import exits
from stucksolver_eval.sites.parameter_draws import flow_values
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class HighwayExit(ActorFlow):
    """There is a flow in the lane next to the hero's; the hero must cross it to leave the motorway."""

    type = "HighwayExit"
    placed = SuitePlacement("bench220", 1130, exits, flow_values((10, 15), (11, 20), (33, 46)))
    driver_alone = "completed"
    needs_map = "lanes from `start_actor_flow` to `end_actor_flow`"
    all_lanes = False

    def clear_way(self) -> None:
        self.traffic.remove_road_lane(self.lines()[0][0])

    def restore_way(self) -> None:
        """Allow background traffic in the lane again."""
        self.traffic.readd_road_lane(self.lines()[0][0])

    def over(self) -> Callable[[], bool]:
        """Return a check for the end of the junction at which the exit branches off, or of the flow without one."""
        route = self.setting.route
        parts = next((junction for junction in route_junctions(route) if junction.last >= self.trigger_index), None)
        if parts is None:
            return super().over()
        end_s = min(float(route.s_m[parts.last]), route.length_m - 3.0)
        return lambda: self.setting.hero_s_m >= end_s
