"""A lane change that waits for its gap with the nose out: begun at the border, and judged like any running plan.

From a stand inside the lane, a lane change must be proven before it begins, through all the meters to the border. A
vehicle that stands at the border begins at once and gives way on every tick until `Guard.recheck` lets it go on. So
there is one proof for the wait and for the lane change that ends it: they cannot disagree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stucksolver.guard.guard import Guard
from stucksolver.guard.policy import Approvals
from stucksolver.guard.proven_plan import ProvenPlan
from stucksolver.guard.verdict import Verdict
from stucksolver.plan.behaviors import AbortAction, Behavior, NoPathError
from stucksolver.scene.frenet_scene import MOVING_MPS, FrenetScene
from stucksolver.scene.road import LaneDirection


def begin_nosed_out(
    guard: Guard, behaviors: Sequence[Behavior], view: FrenetScene, guided: bool, approvals: Approvals, stops: bool
) -> tuple[Verdict, ProvenPlan] | None:
    """Begin a lane change that was refused only for traffic, with the nose out, by giving way to that traffic.

    The plan is committed from its start: it ends when it is finished, or when `Guard.recheck` ends it.

    Args:
        guard: The guard, which refused the plan only for traffic that will move on.
        behaviors: The behaviors, in order.
        view: The surroundings in road coordinates.
        guided: The passenger's words ask for the plan.
        approvals: What people have approved.
        stops: The path must end at rest.

    Returns:
        The verdict of the first tick and the plan; None if the nose is not out, or if the guard would not give way.
    """
    try:
        proven = guard.lay_out(behaviors, view, guided, approvals, stops)
    except NoPathError:
        return None
    if proven.reverse or not is_nosed_out(guard, proven, view):
        return None
    proven = replace(proven, no_stop=np.ones_like(proven.no_stop))
    verdict = guard.recheck(proven, view, giving_way=True)
    return (verdict, proven) if verdict.accepted or verdict.abort is AbortAction.YIELD else None


def is_nosed_out(guard: Guard, proven: ProvenPlan, view: FrenetScene) -> bool:
    """True if the ego stands with its nose at the border of a lane that the plan enters, turned toward it.

    The lane's traffic then sees where the ego wants to go. Only for lanes of the ego's own direction: nobody waits in
    the lane of oncoming traffic.
    """
    policy = guard.policy.entry
    lanes = proven.path.enters
    if abs(view.ego.speed_mps) > MOVING_MPS or abs(view.ego_yaw) < policy.nose_rad:
        return False
    if any(lane.strip.direction is LaneDirection.OPPOSITE for lane in lanes):
        return False
    turn = 1.0 if view.ego_yaw > 0.0 else -1.0
    sin, cos = abs(np.sin(view.ego_yaw)), np.cos(view.ego_yaw)
    nose = turn * view.ego_d + view.ego.length_m / 2 * sin + view.ego.width_m / 2 * cos
    borders = [lane.at(view.ego_s)[0 if turn > 0.0 else 2] for lane in lanes]
    return any(abs(turn * border - nose) < policy.nose_m for border in borders)
