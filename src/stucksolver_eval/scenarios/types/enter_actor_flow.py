"""EnterActorFlow."""

from __future__ import annotations

from stucksolver_eval.scenarios.actions.actor_flow import ActorFlow
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.placed import Placed
from stucksolver_eval.sites.through import RIGHT_TURNS, SIGNED, Through, enter_flow
from stucksolver_eval.sites.values import flow_values


@scenario
class EnterActorFlow(ActorFlow):
    """A dense flow runs through the junction that the hero turns into; it must find a gap and join."""

    type = "EnterActorFlow"
    placed = Placed(
        "bench220",
        1080,
        Through(RIGHT_TURNS, SIGNED, extra=enter_flow),
        flow_values((12, 20), (17, 30), (30, 39)),
        only_in="interurban",
    )
    driver_alone = "waits for a gap in a flow that is faster than its speed limit"
    needs_map = "lanes from `start_actor_flow` to `end_actor_flow`"
