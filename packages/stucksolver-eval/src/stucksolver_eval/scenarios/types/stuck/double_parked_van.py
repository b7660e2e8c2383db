"""DoubleParkedVan."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenarios.families.crossing_actors import walk_for
from stucksolver_eval.scenarios.families.stuck import PASSABLE_M, StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.parameter_draws import IntegerDraw
from stucksolver_eval.sites.stuck_sites import to_pass
from stucksolver_eval.sites.suite_placement import SuitePlacement

VAN, PERSON = "vehicle.mercedes.sprinter", "walker.pedestrian.0002"
WALK_MPS = 1.2
"""Speed of the person (m/s)."""
WALK_M = 3.0
"""Length of the person's path (m)."""
ASIDE_M = 0.6
"""Distance of the person from the van (m)."""


@scenario
class DoubleParkedVan(StuckScenario):
    """A delivery van with hazard lights blocks the only lane, and a person works next to it: pass with clearance."""

    type = "DoubleParkedVan"
    placed = SuitePlacement("immobilized", 3090, to_pass(two_ways), {"distance": IntegerDraw(40, 48)})
    driver_alone = "stuck behind the van"
    expected = "recover"
    suspends = frozenset({"blocked", "wrong_lane"})
    oncoming_gaps_m = PASSABLE_M
    simplified = "there is no traffic from behind"
    needs_map = "one lane each way"
    blueprints = (VAN, PERSON)

    def stage(self) -> None:
        self._van = self.put_disabled(VAN, right_m=ASIDE_M)
        aside_m = ASIDE_M + self._van.half_width_m + 0.7
        self._person = self.spawn_at(PERSON, -self._van.half_length_m, aside_m)

    def situation(self) -> Iterator[None]:
        # The hero needs space behind it to back up and see past the van.
        self.traffic.switch_route_sources(False)
        self.traffic.remove_behind()
        end_s = self.s_at(self.distance_m) + 10.0
        for _ in self._work():
            if self.gap_m(end_s) < 0.0:
                return
            yield

    def _work(self) -> Iterator[None]:
        """Script: the person walks to the load and back forever."""
        yaw = self.ahead(self.distance_m).transform.rotation.yaw
        while True:
            for turn_deg in (0.0, 180.0):
                yield from walk_for(self, self._person, yaw + turn_deg, WALK_MPS, WALK_M)
                yield from self.wait(2.0)
