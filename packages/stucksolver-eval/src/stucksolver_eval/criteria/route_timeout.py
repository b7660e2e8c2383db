"""The time limit of a route (RouteTimeoutBehavior) and the limit on ticks (Bench2Drive's TickRuntime)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stucksolver_eval.criteria.criterion import Criterion, EgoTick
from stucksolver_eval.criteria.route_completion import WINDOW
from stucksolver_eval.criteria.route_position import RouteWalk

if TYPE_CHECKING:
    import carla

FIRST_S = 300.0
"""Time limit before the first stretch (s). As in Bench2Drive."""
SPEED_SHARE = 0.1
"""Share of the speed limit that suffices for each stretch. As in Bench2Drive."""
TICKS = 4000
"""Maximum number of ticks of a route. As in Bench2Drive's TickRuntime."""
TIMED_OUT, TICK_RUNTIME = "Agent timed out", "TickRuntime"


class RouteTimeout(Criterion):
    """Limits the time to 300 s, plus the time of each driven stretch at a tenth of the speed limit.

    A speed limit of 0 adds nothing (the benchmark's own code divides by it and aborts the route).
    """

    kind = "route_timeout"

    def __init__(self, walk: RouteWalk, ego: carla.Vehicle) -> None:
        super().__init__()
        self._walk = walk
        self._ego = ego
        self._index = 0
        self._budget_s = FIRST_S

    def update(self, moment: EgoTick) -> None:
        index = self._walk.last_passed(self._index, moment.location, WINDOW)
        limit_mps = float(self._ego.get_speed_limit()) / 3.6
        if index > self._index and limit_mps > 0.0:
            self._budget_s += (self._walk.s_m[index] - self._walk.s_m[self._index]) / (SPEED_SHARE * limit_mps)
        self._index = index
        if moment.time_s > self._budget_s and self.ends_route is None:
            self.ends_route = TIMED_OUT
            self.note(moment.time_s, f"the route took longer than {self._budget_s:.0f} s")


class TickRuntime(Criterion):
    """Ends the route after 4000 ticks, without an entry. Suspended ticks do not count."""

    kind = "tick_runtime"

    def __init__(self, limit: int = TICKS) -> None:
        super().__init__()
        self._ticks = 0
        self._limit = limit

    def update(self, moment: EgoTick) -> None:
        if self.kind not in moment.suspended:
            self._ticks += 1
        if self._ticks > self._limit:
            self.ends_route = TICK_RUNTIME
