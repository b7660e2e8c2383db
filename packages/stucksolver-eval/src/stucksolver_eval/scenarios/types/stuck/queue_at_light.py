"""QueueAtLight."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.background_traffic.lanes import back
from stucksolver_eval.scenarios.families.stuck import StuckAtLight
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import LIT, STRAIGHT, JunctionSites
from stucksolver_eval.sites.suite_placement import SuitePlacement

CARS = 3
"""Number of cars in the queue."""
SPACING_M = 8.0
"""Distance between the cars (m)."""
BEFORE_LINE_M = 4.0
"""Distance of the first car before the stop line (m)."""


@scenario
class QueueAtLight(StuckAtLight):
    """A control: cars wait ahead of the hero at a red light, and go when it turns green."""

    type = "QueueAtLight"
    placed = SuitePlacement("immobilized", 3200, JunctionSites(STRAIGHT, LIT))
    driver_alone = "completed: waits 37 s"
    expected = "wait"
    starts = "the queue is there from the trigger on; the light turns green 30 s after the hero came near"

    def situation(self) -> Iterator[None]:
        self.hold_lights(green=[])
        self.traffic.handle_junction_scenario()
        queue = []
        for k in range(CARS):
            place = back(self.entry, BEFORE_LINE_M + k * SPACING_M)
            member = None if place is None else self.cast.spawn(self.cast.some_car(self.random), place.transform)
            if member is not None:
                self.cast.hold(member)
                queue.append((member, place))
        yield from self.hero_near()
        yield from self.wait(self.lasts_s)
        self.hold_lights(green=self.own_lights)
        for member, place in queue:
            self.cars.drive(member, place, self.limit_mps, begin=False)
            yield from self.wait(1.0)
