"""VanillaNonSignalizedTurn."""

from __future__ import annotations

from stucksolver_eval.scenarios.actions.traffic_signs import PlainTurn
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.placed import Placed
from stucksolver_eval.sites.through import TURNS, Through


@scenario
class VanillaNonSignalizedTurn(PlainTurn):
    """The hero turns at a junction without lights."""

    type = "VanillaNonSignalizedTurn"
    placed = Placed("bench220", 1360, Through(TURNS, frozenset({"yield", "none"})))
    driver_alone = "completed"
