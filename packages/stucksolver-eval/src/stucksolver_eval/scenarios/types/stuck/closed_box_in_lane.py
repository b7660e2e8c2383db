"""ClosedBoxInLane."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.stuck import PASSABLE_M, Stuck
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.parameter_draws import Value
from stucksolver_eval.sites.stuck_sites import to_pass
from stucksolver_eval.sites.suite_placement import Placed


@scenario
class ClosedBoxInLane(Stuck):
    """A closed box with unknown content lies in the only lane: drive around it, never over it."""

    type = "ClosedBoxInLane"
    placed = Placed("immobilized", 3030, to_pass(two_ways), {"distance": Value(40, 48)})
    driver_alone = "stuck before the box"
    expected = "recover"
    suspends = frozenset({"blocked", "wrong_lane"})
    oncoming_gaps_m = PASSABLE_M
    needs_map = "one lane each way"
    blueprints = ("static.prop.cardboardbox",)

    def stage(self) -> None:
        self.put("static.prop.cardboardbox")
