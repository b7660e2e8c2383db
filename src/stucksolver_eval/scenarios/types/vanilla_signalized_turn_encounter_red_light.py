"""VanillaSignalizedTurnEncounterRedLight."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.traffic_signs import LitTurn
from stucksolver_eval.scenarios.registry import scenario


@scenario
class VanillaSignalizedTurnEncounterRedLight(LitTurn):
    """The hero's light is red for 5 s from the trigger on, then green; all others stay red."""

    type = "VanillaSignalizedTurnEncounterRedLight"
    starts = "the lights are held from the trigger on"
    lit = "red"
