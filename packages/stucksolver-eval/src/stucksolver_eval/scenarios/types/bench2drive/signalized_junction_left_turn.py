"""SignalizedJunctionLeftTurn."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.turn_against_flow import LeftTurn
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import LEFT_TURNS, LIT, OPPOSITE, JunctionSites
from stucksolver_eval.sites.parameter_draws import flow_values
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class SignalizedJunctionLeftTurn(LeftTurn):
    """The hero turns left across an oncoming flow; its light is red for 5 s, then green like the flow's."""

    type = "SignalizedJunctionLeftTurn"
    placed = SuitePlacement(
        "bench220", 1310, JunctionSites(LEFT_TURNS, LIT, from_sides=OPPOSITE), flow_values((8, 12), (15, 24), (25, 30))
    )
    driver_alone = "waits for a gap and finds none"
    starts = "the flow runs from the trigger on"
    needs_map = f"{LeftTurn.needs_map} and traffic lights"
    signalized = True
