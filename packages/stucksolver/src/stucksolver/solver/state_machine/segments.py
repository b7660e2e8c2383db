"""Groups the behaviors of a plan into the stretches that are proven as one path."""

from __future__ import annotations

import numpy as np

from stucksolver.guard import OK, Approvals, GuardPolicy, ProvenPlan, Verdict
from stucksolver.guard.turn_around import unreleased_line
from stucksolver.plan.behaviors import Behavior, Check, drives_legs
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.path_points import facing

Segment = tuple[Behavior, ...]
"""Behaviors that are proven as one path, or one that is proven alone."""

ALONE = frozenset({Check.CREEP_SPEED, Check.WITHIN_LANE, Check.ROADSIDE, Check.STOPPING_PLACE, Check.TURNING})
"""Behaviors with their own bounds on the whole path are proven separately."""


def segments_of(behaviors: tuple[Behavior, ...]) -> tuple[tuple[Behavior, ...], ...]:
    """Group behaviors that follow each other without a stop, to prove them as one path; the others stay single."""
    segments: list[list[Behavior]] = []
    joined = False
    for behavior in behaviors:
        alone = behavior.stands_still or behavior.reverse or bool(ALONE & set(behavior.checks))
        if joined and not alone:
            segments[-1].append(behavior)
        else:
            segments.append([behavior])
        joined = not alone
    return tuple(map(tuple, segments))


def later_turn_released(
    later: tuple[Segment, ...], proven: ProvenPlan | None, view: FrenetScene, policy: GuardPolicy, approvals: Approvals
) -> Verdict:
    """Judge whether a turn later in the plan lacks an approval, before the stretch that leads to it begins."""
    turn = next((behavior for segment in later for behavior in segment if drives_legs(behavior)), None)
    if turn is None:
        return OK
    at = (view.ego.x_m, view.ego.y_m)
    if proven is not None:
        x, y, _ = facing(view, proven).frame.to_local(np.array([proven.path.end_s]), np.array([proven.path.end_d]))
        at = (float(x[0]), float(y[0]))
    return unreleased_line(turn, at, view, policy, approvals)
