"""VanillaSignalizedTurnEncounterRedLight."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.controlled_turn import LitTurn
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import LIT, TURNS, Through
from stucksolver_eval.sites.suite_placement import Placed


@scenario
class VanillaSignalizedTurnEncounterRedLight(LitTurn):
    """The hero's light is red for 5 s from the trigger on, then green; all others stay red."""

    type = "VanillaSignalizedTurnEncounterRedLight"
    placed = Placed("bench220", 1390, Through(TURNS, LIT))
    driver_alone = "completed: waits for green"
    starts = "the lights are controlled from the trigger on"
    lit = "red"
