"""MergerIntoSlowTrafficV2."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.actor_flow import ActorFlow
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.motorway_sites import merges
from stucksolver_eval.sites.parameter_draws import flow_values
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class MergerIntoSlowTrafficV2(ActorFlow):
    """The hero must merge from a ramp into slow flows in all lanes; no other traffic leaves the junction."""

    type = "MergerIntoSlowTrafficV2"
    placed = SuitePlacement("bench220", 1180, merges, flow_values((10, 10), (11, 15), (30, 35)))
    driver_alone = "completed: merges behind a car"
    needs_map = "lanes from `start_actor_flow` to `end_actor_flow`"
