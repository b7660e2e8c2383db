"""Begins a lane change with the front at the lane border, where the ego waits for its gap like in any running plan.

A lane change from a stop inside the lane must be proven before it begins, over the whole distance to the border. An ego
that has stopped at the border begins at once and yields on every tick until `Guard.recheck` lets it continue. The wait
and the lane change that ends it have the same proof, so they cannot disagree.
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
    """Begin a lane change from the border that was rejected only for traffic, by yielding to that traffic.

    The plan is committed from its start: it ends when it is finished, or when `Guard.recheck` ends it.

    Args:
        guard: Guard that rejected the plan only for traffic that will move on.
        behaviors: Behaviors, in order.
        view: Surroundings in road coordinates.
        guided: True if the passenger's guidance requests the plan.
        approvals: Approvals by people.
        stops: True if the path must end in a stop.

    Returns:
        Verdict of the first tick and the plan; None if the ego has not nosed out, or if the guard does not yield.
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
    """True if the ego has stopped with its front at the border of a lane that the plan enters, turned toward it.

    The traffic of that lane can then detect the ego's intent. Only for lanes in the ego's direction: no vehicle waits
    in the lane of oncoming traffic.
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
