"""ClosedRoad."""

from __future__ import annotations

from stucksolver.evaluate.background.lanes import oncoming_lanes
from stucksolver.evaluate.scenarios.moves.places import beside
from stucksolver.evaluate.scenarios.moves.stuck import Stuck
from stucksolver.evaluate.scenarios.registry import scenario

BARRIER, SIGN = "static.prop.streetbarrier", "static.prop.warningconstruction"
BARRIERS_EACH, BARRIER_M = 3, 1.2


@scenario
class ClosedRoad(Stuck):
    """The road is closed from kerb to kerb: leave the route and come to the destination another way."""

    type = "ClosedRoad"
    expected = "reroute"
    suspends = frozenset({"blocked", "route_deviation"})
    blueprints = (BARRIER, SIGN)

    def stage(self) -> None:
        lane = self.ahead(self.distance_m)
        for one in (lane, *oncoming_lanes(lane)):
            for k in range(BARRIERS_EACH):
                place = beside(one, (k - 1) * BARRIER_M, turn_deg=90.0)
                self.cast.must_spawn(BARRIER, place, lift_m=0.0)
        self.put(SIGN, -3.0, 0.0, turn_deg=180.0)
