"""SignalizedJunctionLeftTurn."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.turning import LeftTurn
from stucksolver_eval.scenarios.registry import scenario


@scenario
class SignalizedJunctionLeftTurn(LeftTurn):
    """The hero turns left across an oncoming flow; its light is red for 5 s, then green like the flow's."""

    type = "SignalizedJunctionLeftTurn"
    starts = "the flow runs from the trigger on"
    needs_map = f"{LeftTurn.needs_map} and traffic lights"
    signalized = True
