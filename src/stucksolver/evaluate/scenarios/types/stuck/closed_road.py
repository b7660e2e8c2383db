"""ClosedRoad."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver.evaluate.background.lanes import beside as lane_beside
from stucksolver.evaluate.background.lanes import oncoming_lanes, slots
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
    simplified = "nobody else drives into the closed road"
    blueprints = (BARRIER, SIGN)

    def script(self) -> Iterator[None]:
        self.traffic.handle_junction_scenario()
        self.traffic.switch_route_sources(False)
        self.traffic.remove_behind()
        # Until the drive is over: whoever plans anew has another route from here on.
        yield from self.until(lambda: False)

    def stage(self) -> None:
        lane = self.ahead(self.distance_m)
        mine = [one for slot in slots(lane) if (one := lane_beside(lane, slot)) is not None]
        for one in (*mine, *oncoming_lanes(lane)):
            for k in range(BARRIERS_EACH):
                place = beside(one, (k - 1) * BARRIER_M, turn_deg=90.0)
                self.cast.must_spawn(BARRIER, place, lift_m=0.0)
        self.put(SIGN, -3.0, 0.0, turn_deg=180.0)
