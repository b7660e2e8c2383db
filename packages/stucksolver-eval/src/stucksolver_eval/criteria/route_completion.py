"""The completed part of the route (RouteCompletionTest)."""

from __future__ import annotations

from stucksolver_eval.criteria.criterion import Criterion, EgoTick
from stucksolver_eval.criteria.route_position import RouteWalk

WINDOW = 2
"""Number of route points ahead that are searched. As in RouteCompletionTest."""
NEAR_END_PCT = 99.0
"""Share of the route from which its end may count as reached (%). As in RouteCompletionTest."""
NEAR_END_M = 10.0
"""Distance from the destination at which it counts as reached (m). As in RouteCompletionTest."""


class RouteCompletion(Criterion):
    """The completed part of the route.

    Attributes:
        percentage: Share of the route up to the last passed point, at most three points ahead; 100 near the end.
        index: Index of that point.
        complete: True if the destination is reached, and the route is over.
    """

    kind = "route_completion"

    def __init__(self, walk: RouteWalk) -> None:
        super().__init__()
        self._walk = walk
        self.index = 0
        self.percentage = 0.0
        self.complete = False

    def update(self, moment: EgoTick) -> None:
        if self.complete:
            return
        walk = self._walk
        self.index = walk.last_passed(self.index, moment.location, WINDOW)
        self.percentage = round(100.0 * walk.s_m[self.index] / walk.length_m, 2)
        if self.percentage > NEAR_END_PCT and walk.distance_3d_m(len(walk) - 1, moment.location) < NEAR_END_M:
            self.percentage, self.complete = 100.0, True

    @property
    def s_m(self) -> float:
        """Arc length of the last point passed."""
        return self._walk.s_m[self.index]
