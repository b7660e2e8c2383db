"""DebrisInLane."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.stuck import Stuck
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import one_lane
from stucksolver_eval.sites.lane_sites import Along
from stucksolver_eval.sites.parameter_draws import Value
from stucksolver_eval.sites.suite_placement import Placed


@scenario
class DebrisInLane(Stuck):
    """A flat paper bag lies in the only lane: it can be driven over."""

    type = "DebrisInLane"
    placed = Placed("immobilized", 3020, Along(one_lane), {"distance": Value(40, 48)})
    driver_alone = "stuck before the bag"
    expected = "recover"
    suspends = frozenset({"blocked"})
    blueprints = ("static.prop.paperbag",)

    def stage(self) -> None:
        self.put("static.prop.paperbag")
