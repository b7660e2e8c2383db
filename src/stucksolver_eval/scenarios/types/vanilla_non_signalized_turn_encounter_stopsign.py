"""VanillaNonSignalizedTurnEncounterStopsign."""

from __future__ import annotations

from stucksolver_eval.scenarios.actions.traffic_signs import PlainTurn
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.placed import Placed
from stucksolver_eval.sites.through import TURNS, Through


@scenario
class VanillaNonSignalizedTurnEncounterStopsign(PlainTurn):
    """The hero turns at a junction with a stop sign."""

    type = "VanillaNonSignalizedTurnEncounterStopsign"
    placed = Placed("bench220", 1370, Through(TURNS, frozenset({"stop"})))
    driver_alone = "completed: stops at the sign"
