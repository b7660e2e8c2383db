"""Finds blockers in the lane: objects that are stopped or slow for a reason of their own, not in a queue."""

from __future__ import annotations

import numpy as np

from stucksolver_carla.drivers.behavior.route_bodies import RouteObjects
from stucksolver_carla.drivers.planner.pass_planner import TWO_WHEELER_M, PassContext

REACH_M = 20.0
"""Range ahead of the bumper: the constant part (m). Ours."""
REACH_S = 4.5
"""Range ahead of the bumper: the part that grows with the ego's speed (s). Ours."""
STOPPED_MPS = 0.4
"""Speed below which an object counts as stopped (m/s). Ours."""
SLOW_SHARE = 0.6
"""Share of the ego's cruise speed below which a two-wheeler is passed. Ours."""
STOPPED_S = 2.5
"""Time stopped, without a reason to wait ahead, from which a vehicle is parked or broken down (s). Ours."""
STOPPED_AT_JUNCTION_S = 25.0
"""Time stopped from which this holds for a vehicle near a stop line or a junction (s). Ours."""
QUEUE_M = 45.0
"""Distance to a stop line or a junction below which a vehicle may be waiting at it (m). Ours."""
PEDESTRIAN_STOPPED_S = 5.0
"""Time stopped from which a pedestrian in the lane is passed (s). Ours."""
CONTACT_M = 0.25
"""Clearance at the ego's sides below which an object is in the ego's way (m). Ours."""


class Blockers:
    """The times since which objects have been stopped, and the choice of the blocker."""

    def __init__(self) -> None:
        self._stopped_since_s: dict[int, float] = {}
        self.static_ids: frozenset[int] = frozenset()
        """Ids of objects that are neither vehicles nor pedestrians nor animals. The driver sets them."""

    def observe(self, bodies: RouteObjects, now_s: float) -> None:
        """Update the times for the objects that are stopped now."""
        stopped = bodies.actor_id[bodies.speed < STOPPED_MPS].tolist()
        self._stopped_since_s = {obj: self._stopped_since_s.get(obj, now_s) for obj in stopped}

    def stationary_for_s(self, actor_id: int, now_s: float) -> float:
        """Return the time for which an object has been stopped (s); 0 if it moves."""
        return now_s - self._stopped_since_s.get(actor_id, now_s)

    def first_blocker(self, context: PassContext, now_s: float, line_m: float, hazard: frozenset[int]) -> int | None:
        """Return the index of the first blocker; None without one, or if a slow object before it is no blocker.

        `line_m` is the arc length of the next stop line on the route (m). `hazard` contains the ids of vehicles with
        hazard lights.
        """
        bodies, half_m = context.bodies, context.model.half_width + CONTACT_M
        front = context.s_m + context.model.half_length
        reach = REACH_M + REACH_S * context.speed_mps
        gap = bodies.s - bodies.along - front
        is_ahead = (np.abs(bodies.d) - bodies.aside < half_m) & (gap > -1.0) & (gap < reach) & (bodies.s > context.s_m)
        nearest_first: list[int] = sorted(np.flatnonzero(is_ahead).tolist(), key=lambda k: float(gap[k]))
        for k in nearest_first:
            if self._is_blocker(context, k, now_s, line_m, hazard):
                return k
            if bodies.vs[k] < SLOW_SHARE * context.cruise_mps:
                return None
        return None

    def _is_blocker(self, context: PassContext, k: int, now_s: float, line_m: float, hazard: frozenset[int]) -> bool:
        bodies = context.bodies
        actor_id, speed = int(bodies.actor_id[k]), float(bodies.speed[k])
        stopped_s = self.stationary_for_s(actor_id, now_s)
        if bodies.is_walker[k]:
            return stopped_s > PEDESTRIAN_STOPPED_S
        if speed > STOPPED_MPS:
            two_wheels = bodies.aside[k] < TWO_WHEELER_M
            return bool(two_wheels and bodies.vs[k] > 0.0 and speed < SLOW_SHARE * context.cruise_mps)
        if actor_id in hazard or actor_id in self.static_ids:
            return True
        end = float(bodies.s[k] + bodies.along[k])
        may_wait = min(line_m, context.sides.junction_after(end)) - end < QUEUE_M
        return stopped_s > (STOPPED_AT_JUNCTION_S if may_wait else STOPPED_S)
