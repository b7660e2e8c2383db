"""NonSignalizedJunctionRightTurn."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.turning import RightTurn
from stucksolver_eval.scenarios.registry import scenario


@scenario
class NonSignalizedJunctionRightTurn(RightTurn):
    """The hero turns right into a flow from the left, with no lights."""

    type = "NonSignalizedJunctionRightTurn"
    starts = "the flow runs from the trigger on"
