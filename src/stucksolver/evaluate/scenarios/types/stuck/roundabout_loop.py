"""RoundaboutLoop."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver.evaluate.background.lanes import route_junctions
from stucksolver.evaluate.scenarios.base import Scenario
from stucksolver.evaluate.scenarios.moves.places import beside
from stucksolver.evaluate.scenarios.registry import scenario
from stucksolver.evaluate.scenarios.setting import Setting

BARRIER = "static.prop.streetbarrier"
BEHIND_EXIT_M, BARRIER_M = 6.0, 1.2


@scenario
class RoundaboutLoop(Scenario):
    """The exit that the route takes out of a roundabout is closed: go round and leave elsewhere, not round for ever."""

    type = "RoundaboutLoop"
    expected = "reroute"
    timeout_s = None
    suspends = frozenset({"blocked", "route_deviation"})
    starts = "the exit is closed from the start"
    needs_map = "at least two junctions on the route after the trigger point"
    simplified = "a driver that cannot go round stands before the barrier instead of driving in circles"
    blueprints = (BARRIER,)

    def needs(self, setting: Setting) -> str | None:
        inside = [one for one in route_junctions(setting.route) if one.last >= self.trigger_index]
        return None if len(inside) > 1 else "the route does not lead through a roundabout after the trigger point"

    def stage(self) -> None:
        route = self.setting.route
        last = route_junctions(route)[-1]
        exit_s = min(float(route.s_m[last.last]) + BEHIND_EXIT_M, route.length_m)
        lane = route.at(exit_s)
        for k in range(3):
            self.cast.must_spawn(BARRIER, beside(lane, (k - 1) * BARRIER_M, turn_deg=90.0), lift_m=0.0)

    def script(self) -> Iterator[None]:
        yield from self.until(self.at_route_end)
