"""BlockedIntersection."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenarios.families.junction import JunctionScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import ALL_WAYS, JunctionSites
from stucksolver_eval.sites.suite_placement import SuitePlacement

BEHIND_EXIT_M = 5.0
"""Distance of the car beyond the junction's exit (m)."""
NEAR_M = 13.0
"""Distance of the hero at which the time starts (m)."""
STANDS_S = 10.0
"""Time from then until the car disappears (s)."""


@scenario
class BlockedIntersection(JunctionScenario):
    """A car is stopped just beyond the junction's exit; the hero must wait until it is gone."""

    type = "BlockedIntersection"
    placed = SuitePlacement("bench220", 1020, JunctionSites(ALL_WAYS))
    driver_alone = "completed: waits 13 s until the car is gone"
    starts = "the car is there from the trigger on, and disappears 10 s after the hero came within 13 m"

    def script(self) -> Iterator[None]:
        self.traffic.handle_junction_scenario(extend_exit_m=BEHIND_EXIT_M + 20.0)
        place_s = min(self.exit_s + BEHIND_EXIT_M, self.setting.route.length_m)
        car = self.cast.must_spawn(self.cast.some_car(self.random), self.setting.route.waypoint_at(place_s).transform)
        self.cast.hold(car)
        yield from self.until(lambda: self.gap_m(place_s) < NEAR_M)
        yield from self.wait(STANDS_S)
        self.cast.remove([car])
