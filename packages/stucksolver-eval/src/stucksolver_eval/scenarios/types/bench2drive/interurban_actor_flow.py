"""InterurbanActorFlow."""

from __future__ import annotations

from collections.abc import Callable

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.actor_flow import ActorFlow
from stucksolver_eval.scenarios.families.junction import JunctionScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import LEFT_TURNS, JunctionSites, oncoming_flow
from stucksolver_eval.sites.parameter_draws import flow_values
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class InterurbanActorFlow(ActorFlow, JunctionScenario):
    """The hero turns left off an interurban road, across a fast oncoming flow."""

    type = "InterurbanActorFlow"
    placed = SuitePlacement(
        "bench220",
        1140,
        JunctionSites(LEFT_TURNS, frozenset({"none"}), arms=3, extra=oncoming_flow),
        flow_values((15, 20), (33, 54), (78, 99)),
        only_in="interurban",
    )
    driver_alone = "completed: turns in a gap"
    needs_map = "a junction on the route, and lanes from `start_actor_flow` to `end_actor_flow`"
    all_lanes = False

    def needs(self, setting: ScenarioContext) -> str | None:
        return JunctionScenario.needs(self, setting) or ActorFlow.needs(self, setting)

    def over(self) -> Callable[[], bool]:
        return self.passes_exit
