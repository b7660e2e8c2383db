"""VanillaNonSignalizedTurnEncounterStopsign."""

from __future__ import annotations

from stucksolver.evaluate.scenarios.moves.traffic_signs import PlainTurn
from stucksolver.evaluate.scenarios.registry import scenario


@scenario
class VanillaNonSignalizedTurnEncounterStopsign(PlainTurn):
    """The hero takes a junction with a stop sign."""

    type = "VanillaNonSignalizedTurnEncounterStopsign"
