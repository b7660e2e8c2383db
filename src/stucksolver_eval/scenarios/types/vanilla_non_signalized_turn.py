"""VanillaNonSignalizedTurn."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.traffic_signs import PlainTurn
from stucksolver_eval.scenarios.registry import scenario


@scenario
class VanillaNonSignalizedTurn(PlainTurn):
    """The hero takes a junction without lights."""

    type = "VanillaNonSignalizedTurn"
