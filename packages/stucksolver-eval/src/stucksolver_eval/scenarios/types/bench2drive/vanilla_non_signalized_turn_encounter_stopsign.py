"""VanillaNonSignalizedTurnEncounterStopsign."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.controlled_turn import PlainTurn
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import TURNS, Through
from stucksolver_eval.sites.suite_placement import Placed


@scenario
class VanillaNonSignalizedTurnEncounterStopsign(PlainTurn):
    """The hero turns at a junction with a stop sign."""

    type = "VanillaNonSignalizedTurnEncounterStopsign"
    placed = Placed("bench220", 1370, Through(TURNS, frozenset({"stop"})))
    driver_alone = "completed: stops at the sign"
