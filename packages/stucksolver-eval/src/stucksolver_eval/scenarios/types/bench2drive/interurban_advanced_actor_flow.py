"""InterurbanAdvancedActorFlow."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.junction import JunctionScenario, straight_way
from stucksolver_eval.scenarios.families.vehicle_flow import Flow, run_flows
from stucksolver_eval.scenarios.parameters import ChoiceParameter, NumberParameter, RangeParameter
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import LEFT_TURNS, SIGNED, JunctionSites, crossing_flow
from stucksolver_eval.sites.parameter_draws import flow_values
from stucksolver_eval.sites.suite_placement import SuitePlacement

SOURCE_S = 6.0
"""Distance of the flows' source before the junction, in seconds at the flow's speed."""
SINK_M = 60.0
"""Length of the flows after the junction (m)."""


@scenario
class InterurbanAdvancedActorFlow(JunctionScenario):
    """The hero turns left onto an interurban road: across a flow from its left, into a flow from its right."""

    type = "InterurbanAdvancedActorFlow"
    placed = SuitePlacement(
        "bench220",
        1150,
        JunctionSites(LEFT_TURNS, SIGNED, arms=3, extra=crossing_flow),
        flow_values((16, 18), (36, 42), (84, 94)),
        only_in="interurban",
    )
    driver_alone = "completed: turns in a gap, a near miss"
    needs_map = "a junction with roads from the left and from the right"
    simplified = "both flows are derived from the junction's lanes; `direction` names the one that the hero joins"
    direction = ChoiceParameter("direction", "right", options=("left", "right"))
    flow_mps = NumberParameter("flow_speed", 10.0, "m/s")
    gaps_m = RangeParameter("source_dist_interval", (5.0, 7.0), "m")

    def needs(self, setting: ScenarioContext) -> str | None:
        missing = super().needs(setting)
        if missing is None and not (self.entries_from("left") and self.entries_from("right")):
            missing = "the junction does not have roads from both the left and the right"
        return missing

    def script(self) -> Iterator[None]:
        starts = [*self.entries_from("left"), *self.entries_from("right")]
        self.traffic.handle_junction_scenario(remove_entries=starts, remove_exits=[self.exit])
        lines = [self.approach(start, SOURCE_S * self.flow_mps, SINK_M, straight_way) for start in starts]
        flows = [Flow(self, line, self.flow_mps, self.gaps_m) for line in lines]
        for flow in flows:
            flow.fill()
        end_s = self.exit_s + 5.0
        yield from run_flows(flows, lambda: self.gap_m(end_s) < 0.0 or self.at_route_end())
