"""HardBreakRoute."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.actors.actor_pool import lamps
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.scenario import Scenario
from stucksolver_eval.sites.lane_requirements import any_lane
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.suite_placement import SuitePlacement

STOPS_S = 10.0
"""Duration of the stop (s)."""
ENDS_M = 15.0
"""Distance beyond the stop at which the scenario ends (m)."""


@scenario
class HardBreakRoute(Scenario):
    """All cars ahead brake hard, are stopped for ten seconds, and continue."""

    type = "HardBreakRoute"
    placed = SuitePlacement("bench220", 1090, LaneSites(any_lane, 125))
    driver_alone = "completed: is stopped for 13 s"
    timeout_s = None
    starts = "the cars brake at the trigger"

    def script(self) -> Iterator[None]:
        self.traffic.stop_front()
        for car in self.traffic.road.ahead:
            self.cast.lights(car.member, lamps("Brake"))
        yield from self.wait(STOPS_S)
        self.traffic.start_front()
        for car in self.traffic.road.ahead:
            self.cast.lights(car.member, lamps("NONE"))
        here_s = self.setting.hero_s_m
        yield from self.until_passed(here_s + ENDS_M)

    def close(self) -> None:
        self.traffic.start_front()
