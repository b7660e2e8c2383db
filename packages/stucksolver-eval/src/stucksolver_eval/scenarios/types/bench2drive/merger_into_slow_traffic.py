"""MergerIntoSlowTraffic."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.actor_flow import ActorFlow
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.motorway_sites import merges
from stucksolver_eval.sites.parameter_draws import flow_values
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class MergerIntoSlowTraffic(ActorFlow):
    """The hero must merge from a ramp into a slow flow."""

    type = "MergerIntoSlowTraffic"
    placed = SuitePlacement("bench220", 1170, merges, flow_values((9, 10), (14, 16), (30, 45)))
    driver_alone = "completed: a car lets it in"
    needs_map = "lanes from `start_actor_flow` to `end_actor_flow`"
    all_lanes = False
