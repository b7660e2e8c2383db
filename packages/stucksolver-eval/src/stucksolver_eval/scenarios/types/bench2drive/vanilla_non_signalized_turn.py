"""VanillaNonSignalizedTurn."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.controlled_turn import PlainTurn
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import TURNS, JunctionSites
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class VanillaNonSignalizedTurn(PlainTurn):
    """The hero turns at a junction without lights."""

    type = "VanillaNonSignalizedTurn"
    placed = SuitePlacement("bench220", 1360, JunctionSites(TURNS, frozenset({"yield", "none"})))
    driver_alone = "completed"
