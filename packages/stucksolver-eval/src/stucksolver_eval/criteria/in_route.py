"""Leaving the route (InRouteTest)."""

from __future__ import annotations

from stucksolver_eval.criteria.criterion import Criterion, EgoTick, place_text
from stucksolver_eval.criteria.route_position import RouteWalk

FAR_M = 30.0
"""Distance from the route at which the criterion fails (m). As in InRouteTest."""
SAFE_M = 15.0
"""Distance from the route up to which the ego is on it (m). As in InRouteTest."""
FAR_SHARE_PCT = 30.0
"""Share of the route off which the criterion fails (%). As in InRouteTest."""
WINDOW = 5
"""Number of route points ahead that are searched. As in InRouteTest."""
FAILURE = "Agent deviated from the route"


class InRoute(Criterion):
    """Fails 30 m from the route, or after 30 % of its length at least 15 m from it."""

    kind = "route_dev"

    def __init__(self, walk: RouteWalk) -> None:
        super().__init__()
        self._walk = walk
        self._index = 0
        self._out_m = 0.0
        self._safe = True

    def update(self, moment: EgoTick) -> None:
        if self.ends_route is not None or "route_deviation" in moment.suspended:
            return
        walk, place = self._walk, moment.location
        window = range(self._index, min(self._index + WINDOW + 1, len(walk)))
        # The last one of equally near points counts.
        nearest_m, index = min((walk.distance_m(k, place), -k) for k in window)
        index = -index
        off = nearest_m >= FAR_M
        if not off:
            self._safe = nearest_m < SAFE_M
        if index != self._index and not self._safe:
            self._out_m += walk.s_m[index] - walk.s_m[self._index]
            off = off or 100.0 * self._out_m / walk.length_m > FAR_SHARE_PCT
        self._index = index
        if off:
            self.ends_route = FAILURE
            self.note(moment.time_s, f"deviated from the route at {place_text(place)}")
