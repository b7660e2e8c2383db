"""Checks committed sideways moves toward a stationary object for the tracking error that may grow meanwhile.

Before the commit point a tracking error ends the plan with a stop. After it the plan is finished, with an error of up
to `TrackingPolicy.error_m`. On a return into the lane the heading carries the body toward the passed object. A stop for
a contact that is predicted there comes too late.
"""

from __future__ import annotations

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.prediction import relevant, stationary_gaps
from stucksolver.guard.verdict import RejectReason
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet import Array, Mask
from stucksolver.scene.frenet_scene import MOVING_MPS


def early_return(case: CheckContext, no_stop: Mask) -> list[RejectReason]:
    """Check that no committed part of a path leads toward a stationary object that a tracking error then touches.

    Along such a part the gap must stay at least the largest tracking error since the commit point. A smaller gap is
    allowed if the path began to lead there at that gap: beside an object, an error shows in time for a stop.

    Args:
        case: Plan, before it starts.
        no_stop: (stations,): True where the ego is committed, as `abort_stops.commit_mask` returns it.
    """
    view, path, which = case.view, case.path, relevant(case)
    which = which[view.speed[which] <= MOVING_MPS]
    if not len(which) or not no_stop.any():
        return []
    gap = stationary_gaps(case, which)
    towards = (
        np.gradient(path.d, path.s)[:, None] * np.sign(view.d[which] - path.d[:, None])
        > case.policy.tracking.parallel_rad
    )
    begun = np.maximum.accumulate(np.where(towards, 0, np.arange(len(path.s))[:, None]), axis=0)
    least = np.minimum(
        _grown_error(case, no_stop)[:, None] + case.policy.harm.touch_m,
        np.take_along_axis(gap, begun, axis=0) - case.policy.clearance.nearer_m,
    )
    bad = towards & _past_commit(case, no_stop, which) & (gap < least)
    if not bad.any():
        return []
    k, member = (int(index[0]) for index in np.nonzero(bad))
    obj = view.objects[int(which[member])]
    detail = (
        f"{obj.kind.value} {obj.id}: gap {gap[k, member]:.2f} m on the return past the commit point, "
        f"required {least[k, member]:.2f} m with a tracking error"
    )
    time_s, gap_m = float(case.slow.t[k]), float(gap[k, member])
    margin_m = gap_m - float(least[k, member])
    return [
        RejectReason(
            code=RejectCode.GAP,
            detail=detail,
            object_id=obj.id,
            time_s=time_s,
            gap_m=gap_m,
            margin=margin_m,
            unit="m",
        )
    ]


def _grown_error(case: CheckContext, no_stop: Mask) -> Array:
    """(stations,): largest tracking error that can have grown since the commit point (m)."""
    tracking, t = case.policy.tracking, case.slow.t
    since_s = np.maximum(t - t[int(no_stop.argmax())], 0.0)
    grown: Array = np.minimum(tracking.beside_m + tracking.drift_mps * since_s, tracking.error_m)
    return grown


def _past_commit(case: CheckContext, no_stop: Mask, which: Array) -> Mask:
    """(stations, objects): True on committed parts, and for passed objects on the whole rest of the path.

    The front may be back in the ego's lane, where a stop is allowed, before the tail is clear.
    """
    passed = np.array([case.view.objects[int(i)].id in case.path.passes for i in which], dtype=bool)
    begun = np.maximum.accumulate(no_stop)
    result: Mask = no_stop[:, None] | (begun[:, None] & passed)
    return result
