"""NonSignalizedJunctionRightTurn."""

from __future__ import annotations

from stucksolver.evaluate.scenarios.moves.turning import RightTurn
from stucksolver.evaluate.scenarios.registry import scenario


@scenario
class NonSignalizedJunctionRightTurn(RightTurn):
    """The hero turns right into a flow from the left, with no lights."""

    type = "NonSignalizedJunctionRightTurn"
    starts = "the flow runs from the trigger on"
