"""EnterActorFlow."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.actor_flow import ActorFlow
from stucksolver_eval.scenarios.registry import scenario


@scenario
class EnterActorFlow(ActorFlow):
    """A dense flow runs through the junction that the hero turns into; it must find a gap and join."""

    type = "EnterActorFlow"
    needs_map = "lanes from `start_actor_flow` to `end_actor_flow`"
