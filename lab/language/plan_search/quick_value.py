"""A quick value of a plan without a simulator, for the many partial plans that a search compares.

Road users stay at their positions, or keep their velocity if they are ahead. `lab.language.plan_search.lookahead` ranks
the few plans that the search proposes, and takes a hundred times as long for each.
"""

from __future__ import annotations

import math

import numpy as np

from lab.language.plan_search.ego_trajectory import EgoTrajectory, moved
from stucksolver.scene import Surroundings
from stucksolver.scene.boxes import separation
from stucksolver.scene.frenet import Array
from stucksolver.scene.frenet_scene import FrenetScene

HORIZON_S = 25.0
"""Length of the look-ahead (s), as in `lookahead`."""
STEP_S = 0.2
"""Time between the examined poses (s): half a meter at the usual speed of a plan."""
CRUISE_MPS = 6.0
"""Assumed mean speed after the plan, including the start from a stop (m/s). Ours."""
NEARER_M = 0.05
"""Approach from which a road user counts (m): one that has not come nearer was already there. Ours."""
NEAR_M = 0.3
"""Gap of a near miss (m)."""
CONTACT_COSTS_M, NEAR_COSTS_M = 200.0, 20.0
"""Meters of progress that a contact and a near miss outweigh. Ours."""
MOST_PROGRESS_M = 60.0
"""Largest progress that counts (m). Ours."""
BESIDE_M = 0.3
"""Lateral distance from the ego's body from which a road user does not end the free path ahead (m). Ours."""


class QuickValue:
    """Ranks trajectories from one standstill."""

    def __init__(self, surroundings: Surroundings) -> None:
        self._surroundings = surroundings
        self._view = FrenetScene(surroundings)
        rows = [
            (o.x_m, o.y_m, o.yaw_rad, o.vx_mps, o.vy_mps, o.length_m / 2, o.width_m / 2) for o in surroundings.objects
        ]
        self._x, self._y, self._yaw, self._vx, self._vy, *half = np.array(rows, np.float64).reshape(-1, 7).T
        self._half = half[0], half[1]
        ego = surroundings.ego
        ahead = (self._x - ego.x_m) * math.cos(ego.yaw_rad) + (self._y - ego.y_m) * math.sin(ego.yaw_rad)
        # Traffic behind would brake for a stationary vehicle.
        self._rolls = ahead >= 0.0
        self._first_m = self._gaps(np.zeros(1), np.array([[ego.x_m, ego.y_m, ego.yaw_rad]]), 0.0)[0]

    def value(self, trail: EgoTrajectory) -> float:
        """Return the expected progress minus the cost of contacts and near misses (m)."""
        t = np.append(np.arange(0.0, trail.end_s, STEP_S), trail.end_s)
        pose = np.column_stack([np.interp(t, trail.t, trail.pose[:, k]) for k in range(3)])
        progress = min(self._progress(trail), MOST_PROGRESS_M)
        return progress - float(np.mean([self._cost(self._gaps(t, pose, share)) for share in (0.0, 1.0)]))

    def _cost(self, gaps: Array) -> float:
        least_m = float(gaps[gaps < self._first_m - NEARER_M].min(initial=math.inf))
        return CONTACT_COSTS_M if least_m <= 0.0 else NEAR_COSTS_M * (least_m < NEAR_M)

    def _gaps(self, t: Array, pose: Array, share: float) -> Array:
        """Return the gaps (n, objects) (m) at times and poses, if all ahead move with this share of their velocity."""
        on = share * np.where(self._rolls, t[:, None], 0.0)
        theirs = self._x + on * self._vx, self._y + on * self._vy, self._yaw
        half = self._surroundings.ego.length_m / 2, self._surroundings.ego.width_m / 2
        return separation((pose[:, :1], pose[:, 1:2], pose[:, 2:]), half, theirs, self._half)

    def _progress(self, trail: EgoTrajectory) -> float:
        """Return the distance along the route at the end of the horizon (m): trajectory and free path after it."""
        end = FrenetScene(moved(self._surroundings, trail))
        rest_s = max(HORIZON_S - trail.end_s, 0.0)
        ahead = end.s - end.along - (end.ego_s + end.ego.length_m / 2)
        in_the_way = (np.abs(end.d) - end.across < end.ego.width_m / 2 + BESIDE_M) & (end.s > end.ego_s)
        free = np.maximum(ahead + np.maximum(end.vs, 0.0) * rest_s, 0.0)[in_the_way]
        done = end.ego_s - self._view.ego_s
        return float(done + min(free.min(initial=math.inf), CRUISE_MPS * rest_s))
