"""VanillaSignalizedTurnEncounterRedLight."""

from __future__ import annotations

from stucksolver_eval.scenarios.actions.traffic_signs import LitTurn
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.placed import Placed
from stucksolver_eval.sites.through import LIT, TURNS, Through


@scenario
class VanillaSignalizedTurnEncounterRedLight(LitTurn):
    """The hero's light is red for 5 s from the trigger on, then green; all others stay red."""

    type = "VanillaSignalizedTurnEncounterRedLight"
    placed = Placed("bench220", 1390, Through(TURNS, LIT))
    driver_alone = "completed: waits for green"
    starts = "the lights are controlled from the trigger on"
    lit = "red"
