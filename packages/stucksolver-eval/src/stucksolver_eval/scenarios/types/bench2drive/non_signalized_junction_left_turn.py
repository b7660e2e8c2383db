"""NonSignalizedJunctionLeftTurn."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.turn_against_flow import LeftTurn
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import LEFT_TURNS, OPPOSITE, UNLIT, JunctionSites
from stucksolver_eval.sites.parameter_draws import flow_values
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class NonSignalizedJunctionLeftTurn(LeftTurn):
    """The hero turns left across an oncoming flow, without traffic lights."""

    type = "NonSignalizedJunctionLeftTurn"
    placed = SuitePlacement(
        "bench220",
        1190,
        JunctionSites(LEFT_TURNS, UNLIT, from_sides=OPPOSITE),
        flow_values((8, 12), (15, 24), (25, 30)),
    )
    driver_alone = "waits for a gap and finds none"
    starts = "the flow runs from the trigger on"
