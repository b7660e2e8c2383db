"""MergeNeverOpens."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenarios.families.actor_flow import ActorFlow
from stucksolver_eval.scenarios.families.deadlock import hero_creeps
from stucksolver_eval.scenarios.families.vehicle_flow import Flow, run_flows
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.motorway_sites import merges
from stucksolver_eval.sites.suite_placement import SuitePlacement

CAR = "vehicle.mini.cooper_s_2021"
SPEED_MPS = 1.5
"""Speed of the traffic (m/s)."""
GAPS_M = (6.5, 7.5)
"""Range of distances between the cars (m)."""
MOST = 40
"""Maximum number of cars."""


@scenario
class MergeNeverOpens(ActorFlow):
    """Traffic crawls bumper to bumper in the lane that the hero must merge into; no gap opens until it noses out."""

    type = "MergeNeverOpens"
    placed = SuitePlacement("immobilized", 3110, merges)
    driver_alone = "stuck next to the lane"
    expected = "recover"
    timeout_s = None
    suspends = frozenset({"blocked"})
    starts = "at the trigger point; the others let the hero in when it was stopped for 4 s and then crept half a meter"
    needs_map = "lanes from `start_actor_flow` to `end_actor_flow`"
    blueprints = (CAR,)
    all_lanes = False

    def script(self) -> Iterator[None]:
        self.clear_way()
        flow = Flow(self, self.lines()[0], SPEED_MPS, GAPS_M, kinds=self.blueprints, most=MOST)
        flow.fill()
        creeps = hero_creeps(self, self.setting.route.length_m)
        for _ in run_flows([flow], self.over()):
            if next(creeps, self) is self:
                flow.let_in()
            yield
        self.restore_way()
