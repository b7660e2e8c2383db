"""Whether the stack may drive on by itself from where a plan was given up."""

from __future__ import annotations

import numpy as np

from stucksolver.decision.manoeuvre import STEP_M, Manoeuvre, lateral, shortest_shift
from stucksolver.guard.case import Case
from stucksolver.guard.policy import GuardPolicy
from stucksolver.guard.predict import standing_gaps
from stucksolver.scene.view import MOVING_MPS, View

ASKEW_RAD, ASIDE_M = 0.2, 0.4
"""Turned or displaced by less, a vehicle counts as being in its lane: what stands before it is before its driver."""
KEPT_M = 0.1
MOST_TURN_RAD = 1.3
SLOW_MPS = 2.0


def clear_to_hand_back(view: View, policy: GuardPolicy) -> bool:
    """Is the ego in its lane, or the tightest way back into it free of all that stands?

    Drivers look along their lane. One whose vehicle stands askew beside an obstacle need not see it, and would steer
    back into it (CARLA's BehaviorAgent does).
    """
    if abs(view.ego_yaw) < ASKEW_RAD and abs(view.ego_d) < ASIDE_M:
        return True
    case = Case(view, _turning_back(view), policy, running=True)
    standing = np.flatnonzero(np.hypot(view.vs, view.vd) <= MOVING_MPS)
    if not len(standing):
        return True
    gap = standing_gaps(case, standing)
    return not ((gap < KEPT_M) & (gap < gap[0] - 0.05)).any()


def _turning_back(view: View) -> Manoeuvre:
    """From the present heading along the road on the smallest circle, then to the middle of the route's lane."""
    radius, side = view.ego.limits.min_turn_radius_m, np.sign(view.ego_yaw)
    first = min(abs(view.ego_yaw), MOST_TURN_RAD)
    turn = np.linspace(first, 0.0, 16)
    along = radius * (np.sin(first) - np.sin(turn))
    aside = side * radius * (np.cos(turn) - np.cos(first))
    s = np.append(np.arange(0.0, float(along[-1]), STEP_M), along[-1])
    arc = Manoeuvre(view.ego_s + s, view.ego_d + np.interp(s, along, aside), np.full(len(s), SLOW_MPS))
    length = max(shortest_shift(arc.end_d, radius), STEP_M)
    return arc.then(lateral(arc.end_s, arc.end_d, 0.0, length, SLOW_MPS, view))
