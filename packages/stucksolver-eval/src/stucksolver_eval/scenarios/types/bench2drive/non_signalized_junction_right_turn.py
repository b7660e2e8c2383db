"""NonSignalizedJunctionRightTurn."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.turn_against_flow import RightTurn
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import FROM_LEFT, RIGHT_TURNS, UNLIT, JunctionSites
from stucksolver_eval.sites.parameter_draws import flow_values
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class NonSignalizedJunctionRightTurn(RightTurn):
    """The hero turns right into a flow from the left, without traffic lights."""

    type = "NonSignalizedJunctionRightTurn"
    placed = SuitePlacement(
        "bench220",
        1210,
        JunctionSites(RIGHT_TURNS, UNLIT, from_sides=FROM_LEFT),
        flow_values((8, 14), (16, 24), (25, 30)),
    )
    driver_alone = "completed: joins in a gap"
    starts = "the flow runs from the trigger on"
