"""PedestriansCrossing."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.actors import ScenarioActor
from stucksolver_eval.scenarios.families.crossing_actors import ADULTS, WALKER_LIFT_M, together, walk_for
from stucksolver_eval.scenarios.families.junction import JunctionScenario
from stucksolver_eval.scenarios.families.lane_places import edge_m, offset_pose
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.stuck_sites import crosswalks
from stucksolver_eval.sites.suite_placement import SuitePlacement

WALKERS = 6
"""Number of pedestrians."""
EVERY_S = 5.0
"""Interval between two pedestrians (s)."""
WALK_MPS = 1.3
"""Speed of the pedestrians (m/s)."""
NEAR_M = 25.0
"""Distance of the hero at which the first one starts (m)."""
BEFORE_M = 2.0
"""Distance of the crossing before the junction (m)."""


@scenario
class PedestriansCrossing(JunctionScenario):
    """A control: pedestrians cross the hero's road one after another for half a minute."""

    type = "PedestriansCrossing"
    placed = SuitePlacement("immobilized", 3210, crosswalks)
    driver_alone = "completed: waits 32 s"
    expected = "wait"
    timeout_s = None
    starts = "the first starts when the hero is 25 m away, then one every 5 s"
    blueprints = ADULTS

    def stage(self) -> None:
        lane = self.setting.route.waypoint_at(self.entry_s - BEFORE_M)
        self._way_m = edge_m(lane) + edge_m(lane, "left") + lane.lane_width
        self._walkers = []
        for k in range(WALKERS):
            place = offset_pose(lane, edge_m(lane) + 0.8 + 0.6 * (k // 2), 0.5 - (k % 2), turn_deg=-90.0)
            self._yaw_deg = place.rotation.yaw
            self._walkers.append(self.cast.must_spawn(self.random.choice(ADULTS), place, lift_m=WALKER_LIFT_M))

    def script(self) -> Iterator[None]:
        place_s = self.entry_s - BEFORE_M
        yield from self.until(lambda: self.gap_m(place_s) < NEAR_M)
        yield from together(*(self._cross(k, walker) for k, walker in enumerate(self._walkers)))
        yield from self.until_passed(self.exit_s + 10.0)

    def _cross(self, k: int, walker: ScenarioActor) -> Iterator[None]:
        yield from self.wait(k * EVERY_S)
        yield from walk_for(self, walker, self._yaw_deg, WALK_MPS, self._way_m + 2.0)
        self.cast.remove([walker])
