"""ClosedBoxInLane."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.stuck import PASSABLE_M, StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.parameter_draws import IntegerDraw
from stucksolver_eval.sites.stuck_sites import to_pass
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class ClosedBoxInLane(StuckScenario):
    """A closed box with unknown content lies in the only lane: drive around it, never over it."""

    type = "ClosedBoxInLane"
    placed = SuitePlacement("immobilized", 3030, to_pass(two_ways), {"distance": IntegerDraw(40, 48)})
    driver_alone = "stuck before the box"
    expected = "recover"
    suspends = frozenset({"blocked", "wrong_lane"})
    oncoming_gaps_m = PASSABLE_M
    needs_map = "one lane each way"
    blueprints = ("static.prop.cardboardbox",)

    def stage(self) -> None:
        self.spawn_at("static.prop.cardboardbox")
