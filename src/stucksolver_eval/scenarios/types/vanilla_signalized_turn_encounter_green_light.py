"""VanillaSignalizedTurnEncounterGreenLight."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.traffic_signs import LitTurn
from stucksolver_eval.scenarios.registry import scenario


@scenario
class VanillaSignalizedTurnEncounterGreenLight(LitTurn):
    """The hero's light is green for 5 s from the trigger on, then red for 5 s, then runs as usual."""

    type = "VanillaSignalizedTurnEncounterGreenLight"
    starts = "the lights are held from the trigger on"
