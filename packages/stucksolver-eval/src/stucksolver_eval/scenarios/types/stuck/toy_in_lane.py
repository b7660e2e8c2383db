"""ToyInLane."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenarios.families.crossing_actors import walk_for
from stucksolver_eval.scenarios.families.lane_places import edge_m, offset_pose
from stucksolver_eval.scenarios.families.stuck import StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import one_lane
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

CHILD, TOY = "walker.pedestrian.0009", "static.prop.toy"
HESITATES_S = 15.0
"""Time until the child starts (s)."""
WALK_MPS = 1.0
"""Speed of the child (m/s)."""


@scenario
class ToyInLane(StuckScenario):
    """A toy lies in the only lane and a child is at the curb; after a while it fetches the toy: wait."""

    type = "ToyInLane"
    placed = SuitePlacement("immobilized", 3040, LaneSites(one_lane), {"distance": IntegerDraw(40, 48)})
    driver_alone = "completed: waits 18 s"
    expected = "wait"
    suspends = frozenset({"blocked"})
    starts = "the child starts 15 s after the hero came within 25 m"
    blueprints = (CHILD, TOY)

    def stage(self) -> None:
        lane = self.ahead(self.distance_m)
        self._way_m = edge_m(lane) + 0.4
        self._toy = self.spawn_at(TOY)
        self._child = self.spawn_at(CHILD, 0.0, self._way_m, turn_deg=-90.0)
        self._yaw_deg = offset_pose(lane, turn_deg=-90.0).rotation.yaw

    def situation(self) -> Iterator[None]:
        yield from self.hero_near()
        yield from self.wait(HESITATES_S)
        reach_m = self._way_m - 0.4
        yield from walk_for(self, self._child, self._yaw_deg, WALK_MPS, reach_m)
        self.cast.remove([self._toy])
        yield from walk_for(self, self._child, self._yaw_deg + 180.0, WALK_MPS, reach_m + 1.0)
