"""EnterActorFlow."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.actor_flow import ActorFlow
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import RIGHT_TURNS, SIGNED, JunctionSites, enter_flow
from stucksolver_eval.sites.parameter_draws import flow_values
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class EnterActorFlow(ActorFlow):
    """A dense flow runs through the junction that the hero turns into; it must find a gap and join."""

    type = "EnterActorFlow"
    placed = SuitePlacement(
        "bench220",
        1080,
        JunctionSites(RIGHT_TURNS, SIGNED, extra=enter_flow),
        flow_values((12, 20), (17, 30), (30, 39)),
        only_in="interurban",
    )
    driver_alone = "waits for a gap in a flow that is faster than its speed limit"
    needs_map = "lanes from `start_actor_flow` to `end_actor_flow`"
