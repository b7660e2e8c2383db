"""InterurbanActorFlow."""

from __future__ import annotations

from collections.abc import Callable

from stucksolver_eval.scenarios.moves.actor_flow import ActorFlow
from stucksolver_eval.scenarios.moves.junction import JunctionScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.setting import Setting


@scenario
class InterurbanActorFlow(ActorFlow, JunctionScenario):
    """The hero turns left off an interurban road, across a fast oncoming flow."""

    type = "InterurbanActorFlow"
    needs_map = "a junction on the route, and lanes from `start_actor_flow` to `end_actor_flow`"
    all_lanes = False

    def needs(self, setting: Setting) -> str | None:
        return JunctionScenario.needs(self, setting) or ActorFlow.needs(self, setting)

    def over(self) -> Callable[[], bool]:
        return self.passes_exit
