"""NonSignalizedJunctionLeftTurn."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.turning import LeftTurn
from stucksolver_eval.scenarios.registry import scenario


@scenario
class NonSignalizedJunctionLeftTurn(LeftTurn):
    """The hero turns left across an oncoming flow, with no lights."""

    type = "NonSignalizedJunctionLeftTurn"
    starts = "the flow runs from the trigger on"
