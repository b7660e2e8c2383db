"""BlockedJunctionBox."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.junction import straight_way
from stucksolver_eval.scenarios.families.stuck import StuckAtLight
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import LIT, STRAIGHT, JunctionSites
from stucksolver_eval.sites.suite_placement import SuitePlacement

CARS = 3
"""Number of cars."""
SPACING_M = 7.5
"""Distance between the cars (m)."""


@scenario
class BlockedJunctionBox(StuckAtLight):
    """The hero's light is green, but cars of the crossing road block the junction; they leave after 30 s: wait."""

    type = "BlockedJunctionBox"
    placed = SuitePlacement("immobilized", 3120, JunctionSites(STRAIGHT, LIT, arms=4))
    driver_alone = "completed: waits 36 s at its green light"
    expected = "wait"
    starts = "the cars are there from the trigger on, and drive off 30 s after the hero came near"
    suspends = frozenset({"blocked"})

    def needs(self, setting: ScenarioContext) -> str | None:
        missing = super().needs(setting)
        if missing is None and not self._crossing():
            missing = "the hero's next junction has no road from the left or right"
        return missing

    def _crossing(self) -> list[Any]:
        return [*self.entries_from("left"), *self.entries_from("right")]

    def situation(self) -> Iterator[None]:
        self.traffic.handle_junction_scenario(remove_entries=self._crossing())
        self.hold_lights(green=self.own_lights)
        line = self.approach(self._crossing()[0], 0.0, 60.0, straight_way)
        inside = [k for k, waypoint in enumerate(line) if waypoint.is_junction]
        # A car needs space entirely inside the junction. The foremost one comes first.
        first, last = inside[0] + round(SPACING_M / 4.0), inside[-1]
        stuck = []
        for index in range(last, first, -round(SPACING_M / 2.0))[:CARS]:
            member = self.cast.spawn(self.cast.some_car(self.random), line[index].transform)
            if member is not None:
                self.cast.hold(member)
                stuck.append((member, line[index:]))
        yield from self.hero_near()
        yield from self.wait(self.lasts_s)
        for member, rest in stuck:
            self.cars.drive(member, rest, self.limit_mps, begin=False, obeys_lights=False)
            yield from self.wait(1.0)
