"""NonSignalizedJunctionLeftTurn."""

from __future__ import annotations

from stucksolver.evaluate.scenarios.moves.turning import LeftTurn
from stucksolver.evaluate.scenarios.registry import scenario


@scenario
class NonSignalizedJunctionLeftTurn(LeftTurn):
    """The hero turns left across an oncoming flow, with no lights."""

    type = "NonSignalizedJunctionLeftTurn"
    starts = "the flow runs from the trigger on"
