"""SignalizedJunctionLeftTurnEnterFlow."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.turn_against_flow import LeftTurnEnterFlow
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import LEFT_TURNS, LIT, JunctionSites, joined
from stucksolver_eval.sites.parameter_draws import flow_values
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class SignalizedJunctionLeftTurnEnterFlow(LeftTurnEnterFlow):
    """The hero turns left into a road that an oncoming flow also turns into; its light is red for 5 s."""

    type = "SignalizedJunctionLeftTurnEnterFlow"
    placed = SuitePlacement(
        "bench220", 1320, JunctionSites(LEFT_TURNS, LIT, extra=joined), flow_values((8, 10), (16, 24), (25, 30))
    )
    driver_alone = "collision: joins in a gap of two seconds"
    starts = "the flow runs from the trigger on"
    needs_map = f"{LeftTurnEnterFlow.needs_map} and traffic lights"
    signalized = True
