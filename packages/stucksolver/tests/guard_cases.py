"""Cases as the guard's checks are given them, for tests of single checks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stucksolver.guard import NOBODY, Guard, RejectCode
from stucksolver.guard.context import CheckContext
from stucksolver.guard.path_tracking import tracked_path
from stucksolver.plan.behaviors import BorrowOncomingLane
from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.scene import (
    LaneDirection,
    LineKind,
)
from worlds import LANE_M, World, straight_road, strip

C = RejectCode
GUARD = Guard()
POLICY = GUARD.policy
MULTI = straight_road(left=LineKind.BROKEN, oncoming=None)
PAST_LEAD = BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)
LENGTH_M = 4.9
WIDTH_M = 1.85
CAR_M = 4.6
RIGHT = strip("right", -LANE_M, LaneDirection.SAME, LineKind.BROKEN, 401)
BOTH = MULTI.model_copy(update={"key": "both", "lanes": (*MULTI.lanes, RIGHT)})
NUMBERS = range(40)


def case_of(world, *behaviors, running=False):
    view = world.view()
    path = tracked_path(GUARD.lay_out(behaviors, view, False, NOBODY).path, view, POLICY.tracking, reverse=False)
    return CheckContext(view, path, POLICY, running=running)


def case_on(d, turn, objects=(), *, start_s=50.0, **world):
    """A path of one's own making, half a meter from station to station."""
    view = World(MULTI, list(objects), x=start_s, **world).view()
    s = start_s + 0.5 * np.arange(len(d))
    path = FrenetPath(s, np.asarray(d, float), np.full(len(d), 5.0), yaw=np.asarray(turn, float))
    return CheckContext(view, path, POLICY)


def on_way(*objects, speed=5.0, x=65.0):
    """A plan that runs straight on for 40 m."""
    case = case_on([0.0] * 80, [0.0] * 80, objects, start_s=x, speed=speed)
    return replace(case, running=True)


def commit_s(proven):
    """The last place before which a stop is always safe; None for a path without a commit point."""
    first = np.flatnonzero(proven.no_stop)
    return float(proven.path.s[max(int(first[0]) - 1, 0)]) if len(first) else None
