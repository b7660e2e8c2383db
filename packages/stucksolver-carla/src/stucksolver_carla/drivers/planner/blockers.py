"""What is worth passing: a body in the lane that is slow for a reason of its own, not in a queue."""

from __future__ import annotations

import numpy as np

from stucksolver_carla.drivers.behavior.route_bodies import RouteObjects
from stucksolver_carla.drivers.planner.pass_planner import TWO_WHEELER_M, PassContext

REACH_M = 20.0
"""How far ahead of the bumper blockers are looked for, besides `REACH_S`."""
REACH_S = 4.5
"""The same in seconds of our drive."""
STANDS_MPS = 0.4
SLOW_SHARE = 0.6
"""A two-wheeler slower than this share of our own speed is passed."""
STOOD_S = 2.5
"""A vehicle that has stood this long, with nothing ahead to wait for, is parked or broken down."""
STOOD_BEFORE_A_JUNCTION_S = 25.0
QUEUE_M = 45.0
"""A vehicle nearer than this to a line or a junction may be waiting at it."""
PERSON_STOOD_S = 5.0
TOUCHES_M = 0.25


class Blockers:
    """Remembers how long each body has been stationary."""

    def __init__(self) -> None:
        self._since: dict[int, float] = {}
        self.things: frozenset[int] = frozenset()
        """Ids of bodies that are neither vehicles nor people; set by whoever reads the world."""

    def see(self, bodies: RouteObjects, now_s: float) -> None:
        """Note which bodies are stationary now."""
        standing = bodies.actor_id[bodies.speed < STANDS_MPS].tolist()
        self._since = {obj: self._since.get(obj, now_s) for obj in standing}

    def stationary_for_s(self, actor_id: int, now_s: float) -> float:
        """Return how long it has been stationary (s); 0 if it moves."""
        return now_s - self._since.get(actor_id, now_s)

    def first(self, here: PassContext, now_s: float, line_m: float, hazard: frozenset[int]) -> int | None:
        """Return the index of the first body worth passing; None if there is none, or if what is ahead of it is not.

        `line_m` is the position of the next stop line along the route (m); `hazard` has the ids of vehicles with hazard
        lights.
        """
        bodies, half = here.bodies, here.model.half_width + TOUCHES_M
        front = here.s_m + here.model.half_length
        reach = REACH_M + REACH_S * here.speed_mps
        gap = bodies.s - bodies.along - front
        ahead = (np.abs(bodies.d) - bodies.aside < half) & (gap > -1.0) & (gap < reach) & (bodies.s > here.s_m)
        nearest_first: list[int] = sorted(np.flatnonzero(ahead).tolist(), key=lambda k: float(gap[k]))
        for k in nearest_first:
            if self._is_worth(here, k, now_s, line_m, hazard):
                return k
            if bodies.vs[k] < SLOW_SHARE * here.cruise_mps:
                return None
        return None

    def _is_worth(self, here: PassContext, k: int, now_s: float, line_m: float, hazard: frozenset[int]) -> bool:
        bodies = here.bodies
        actor_id, speed = int(bodies.actor_id[k]), float(bodies.speed[k])
        stood_s = self.stationary_for_s(actor_id, now_s)
        if bodies.is_walker[k]:
            return stood_s > PERSON_STOOD_S
        if speed > STANDS_MPS:
            two_wheels = bodies.aside[k] < TWO_WHEELER_M
            return bool(two_wheels and bodies.vs[k] > 0.0 and speed < SLOW_SHARE * here.cruise_mps)
        if actor_id in hazard or actor_id in self.things:
            return True
        end = float(bodies.s[k] + bodies.along[k])
        waits = min(line_m, here.sides.junction_after(end)) - end < QUEUE_M
        return stood_s > (STOOD_BEFORE_A_JUNCTION_S if waits else STOOD_S)
