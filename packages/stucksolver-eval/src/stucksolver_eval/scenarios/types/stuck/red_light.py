"""RedLight."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenarios.families.stuck import StuckAtLight
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import ALL_WAYS, LIT, JunctionSites
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class RedLight(StuckAtLight):
    """A control: the hero's light is red for half a minute, then green."""

    type = "RedLight"
    placed = SuitePlacement("immobilized", 3190, JunctionSites(ALL_WAYS, LIT))
    driver_alone = "completed: waits 33 s"
    expected = "wait"
    starts = "the light is red from the trigger on, and green 30 s after the hero came near"

    def situation(self) -> Iterator[None]:
        self.hold_lights(green=[])
        yield from self.hero_near()
        yield from self.wait(self.lasts_s)
        self.hold_lights(green=self.own_lights)
