"""RoundaboutLoop."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.scenario import Scenario
from stucksolver_eval.sites.stuck_sites import round_and_round
from stucksolver_eval.sites.suite_placement import SuitePlacement

LEAST_M = 60.0
"""Shortest loop of the route that counts (m)."""


@scenario
class RoundaboutLoop(Scenario):
    """The route goes around a roundabout again and again, always moving and never leaving: replan and leave."""

    type = "RoundaboutLoop"
    placed = SuitePlacement("immobilized", 3060, round_and_round)
    driver_alone = "stuck: drives around until the time is up"
    expected = "reroute"
    timeout_s = None
    suspends = frozenset({"blocked", "route_deviation"})
    starts = "nothing happens; the route itself goes around"
    needs_map = "a route that returns to an earlier position"

    def needs(self, setting: ScenarioContext) -> str | None:
        route = setting.route
        again_m = route.length_m - float(route.new_ground_m[-1])
        return None if again_m > LEAST_M else "the route never returns to an earlier position"

    def script(self) -> Iterator[None]:
        # The script runs until the end of the drive, because a hero that replans follows another route from here.
        yield from self.until(lambda: False)
