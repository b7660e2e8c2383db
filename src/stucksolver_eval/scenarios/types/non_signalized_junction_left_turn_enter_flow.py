"""NonSignalizedJunctionLeftTurnEnterFlow."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.turning import LeftTurnEnterFlow
from stucksolver_eval.scenarios.registry import scenario


@scenario
class NonSignalizedJunctionLeftTurnEnterFlow(LeftTurnEnterFlow):
    """The hero turns left into a road that an oncoming flow turns into, too, with no lights."""

    type = "NonSignalizedJunctionLeftTurnEnterFlow"
    starts = "the flow runs from the trigger on"
