"""SignalizedJunctionRightTurn."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.turn_against_flow import RightTurn
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import FROM_LEFT, LIT, RIGHT_TURNS, JunctionSites
from stucksolver_eval.sites.parameter_draws import flow_values
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class SignalizedJunctionRightTurn(RightTurn):
    """The hero turns right into a flow from the left; its light is red for 5 s, then green like the flow's."""

    type = "SignalizedJunctionRightTurn"
    placed = SuitePlacement(
        "bench220",
        1330,
        JunctionSites(RIGHT_TURNS, LIT, from_sides=FROM_LEFT),
        flow_values((10, 14), (19, 24), (26, 38)),
    )
    driver_alone = "waits for a gap and finds none"
    starts = "the flow runs from the trigger on"
    needs_map = f"{RightTurn.needs_map} and traffic lights"
    signalized = True
