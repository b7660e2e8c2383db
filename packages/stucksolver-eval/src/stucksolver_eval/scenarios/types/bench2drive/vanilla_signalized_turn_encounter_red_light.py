"""VanillaSignalizedTurnEncounterRedLight."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.controlled_turn import LitTurn
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import LIT, TURNS, JunctionSites
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class VanillaSignalizedTurnEncounterRedLight(LitTurn):
    """The hero's light is red for 5 s from the trigger on, then green; all others stay red."""

    type = "VanillaSignalizedTurnEncounterRedLight"
    placed = SuitePlacement("bench220", 1390, JunctionSites(TURNS, LIT))
    driver_alone = "completed: waits for green"
    starts = "the lights are controlled from the trigger on"
    lit = "red"
