"""SignalizedJunctionRightTurn."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.turning import RightTurn
from stucksolver_eval.scenarios.registry import scenario


@scenario
class SignalizedJunctionRightTurn(RightTurn):
    """The hero turns right into a flow from the left; its light is red for 5 s, then green like the flow's."""

    type = "SignalizedJunctionRightTurn"
    starts = "the flow runs from the trigger on"
    needs_map = f"{RightTurn.needs_map} and traffic lights"
    signalized = True
