"""Decides whether the stack may drive on by itself from where a plan was given up."""

from __future__ import annotations

import numpy as np

from stucksolver.decision.manoeuvre import STEP_M, Manoeuvre, lateral, shortest_shift
from stucksolver.guard.context import CheckContext
from stucksolver.guard.policy import GuardPolicy, HandBackPolicy
from stucksolver.guard.predict import standing_gaps
from stucksolver.scene.view import MOVING_MPS, FrenetScene

SAMPLES = 16
"""Samples of the arc back; finer than the stations of a path."""


def clear_to_hand_back(view: FrenetScene, policy: GuardPolicy) -> bool:
    """True if the ego is in its lane, or the tightest path back into it is clear of stationary objects.

    Driving stacks look along their lane. If the vehicle is askew beside an obstacle, a stack may miss the obstacle and
    steer into it, as CARLA's BehaviorAgent does.
    """
    back = policy.hand_back
    if abs(view.ego_yaw) < back.askew_rad and abs(view.ego_d) < back.aside_m:
        return True
    case = CheckContext(view, _turning_back(view, back), policy, running=True)
    standing = np.flatnonzero(view.speed <= MOVING_MPS)
    if not len(standing):
        return True
    gap = standing_gaps(case, standing)
    return not ((gap < back.kept_m) & (gap < gap[0] - policy.clearance.nearer_m)).any()


def _turning_back(view: FrenetScene, policy: HandBackPolicy) -> Manoeuvre:
    """Return an arc at the smallest radius to the road's direction, followed by a shift to the centre of the
    route's lane.
    """
    radius, side = view.ego.limits.min_turn_radius_m, np.sign(view.ego_yaw)
    first = min(abs(view.ego_yaw), policy.most_turn_rad)
    turn = np.linspace(first, 0.0, SAMPLES)
    along = radius * (np.sin(first) - np.sin(turn))
    aside = side * radius * (np.cos(turn) - np.cos(first))
    s = np.append(np.arange(0.0, float(along[-1]), STEP_M), along[-1])
    arc = Manoeuvre(view.ego_s + s, view.ego_d + np.interp(s, along, aside), np.full(len(s), policy.speed_mps))
    length = max(shortest_shift(arc.end_d, radius), STEP_M)
    return arc.then(lateral(arc.end_s, arc.end_d, 0.0, length, policy.speed_mps, view))
