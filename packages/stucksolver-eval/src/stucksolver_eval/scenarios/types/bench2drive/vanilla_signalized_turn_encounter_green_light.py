"""VanillaSignalizedTurnEncounterGreenLight."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.controlled_turn import LitTurn
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import LIT, TURNS, JunctionSites
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class VanillaSignalizedTurnEncounterGreenLight(LitTurn):
    """The hero's light is green for 5 s from the trigger on, then red for 5 s, then follows its normal cycle."""

    type = "VanillaSignalizedTurnEncounterGreenLight"
    placed = SuitePlacement("bench220", 1380, JunctionSites(TURNS, LIT, trigger_m=20))
    driver_alone = "completed while it is green"
    starts = "the lights are controlled from the trigger on"
