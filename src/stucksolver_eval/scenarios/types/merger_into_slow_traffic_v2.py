"""MergerIntoSlowTrafficV2."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.actor_flow import ActorFlow
from stucksolver_eval.scenarios.registry import scenario


@scenario
class MergerIntoSlowTrafficV2(ActorFlow):
    """From a ramp the hero must merge into slow flows in all lanes, and no other traffic leaves the junction."""

    type = "MergerIntoSlowTrafficV2"
    needs_map = "lanes from `start_actor_flow` to `end_actor_flow`"
