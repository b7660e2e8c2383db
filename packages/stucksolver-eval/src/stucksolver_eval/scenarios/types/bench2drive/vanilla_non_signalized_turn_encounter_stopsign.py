"""VanillaNonSignalizedTurnEncounterStopsign."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.controlled_turn import PlainTurn
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import TURNS, JunctionSites
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class VanillaNonSignalizedTurnEncounterStopsign(PlainTurn):
    """The hero turns at a junction with a stop sign."""

    type = "VanillaNonSignalizedTurnEncounterStopsign"
    placed = SuitePlacement("bench220", 1370, JunctionSites(TURNS, frozenset({"stop"})))
    driver_alone = "completed: stops at the sign"
