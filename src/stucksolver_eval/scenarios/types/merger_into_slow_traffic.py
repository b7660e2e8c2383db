"""MergerIntoSlowTraffic."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.actor_flow import ActorFlow
from stucksolver_eval.scenarios.registry import scenario


@scenario
class MergerIntoSlowTraffic(ActorFlow):
    """From a ramp the hero must merge into a slow flow."""

    type = "MergerIntoSlowTraffic"
    needs_map = "lanes from `start_actor_flow` to `end_actor_flow`"
    all_lanes = False
