"""SignalizedJunctionLeftTurnEnterFlow."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.turning import LeftTurnEnterFlow
from stucksolver_eval.scenarios.registry import scenario


@scenario
class SignalizedJunctionLeftTurnEnterFlow(LeftTurnEnterFlow):
    """The hero turns left into a road that an oncoming flow turns into, too; its light is red for 5 s."""

    type = "SignalizedJunctionLeftTurnEnterFlow"
    starts = "the flow runs from the trigger on"
    needs_map = f"{LeftTurnEnterFlow.needs_map} and traffic lights"
    signalized = True
