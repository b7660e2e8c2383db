"""NonSignalizedJunctionLeftTurnEnterFlow."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.turn_against_flow import LeftTurnEnterFlow
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import LEFT_TURNS, UNLIT, JunctionSites, joined
from stucksolver_eval.sites.parameter_draws import flow_values
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class NonSignalizedJunctionLeftTurnEnterFlow(LeftTurnEnterFlow):
    """The hero turns left into a road that an oncoming flow also turns into, without traffic lights."""

    type = "NonSignalizedJunctionLeftTurnEnterFlow"
    placed = SuitePlacement(
        "bench220", 1200, JunctionSites(LEFT_TURNS, UNLIT, extra=joined), flow_values((8, 10), (15, 19), (26, 30))
    )
    driver_alone = "completed: waits, then slots in behind a car"
    starts = "the flow runs from the trigger on"
