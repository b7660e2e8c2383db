"""DebrisInLane."""

from __future__ import annotations

from stucksolver_eval.scenarios.actions.stuck import Stuck
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.along import Along
from stucksolver_eval.sites.fits import one_lane
from stucksolver_eval.sites.placed import Placed
from stucksolver_eval.sites.values import Value


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
