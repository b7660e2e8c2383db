"""DebrisInLane."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.stuck import StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import one_lane
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class DebrisInLane(StuckScenario):
    """A flat paper bag lies in the only lane: it can be driven over."""

    type = "DebrisInLane"
    placed = SuitePlacement("immobilized", 3020, LaneSites(one_lane), {"distance": IntegerDraw(40, 48)})
    driver_alone = "stuck before the bag"
    expected = "recover"
    suspends = frozenset({"blocked"})
    blueprints = ("static.prop.paperbag",)

    def stage(self) -> None:
        self.spawn_at("static.prop.paperbag")
