"""Finds the positions on a path at which the ego can stop safely, and proves that the stops are safe."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.prediction import moving_gaps, relevant
from stucksolver.guard.through_traffic import goes_straight
from stucksolver.guard.verdict import RejectReason
from stucksolver.plan.frenet_path import STEP_M
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet import Array, Mask
from stucksolver.scene.frenet_scene import MOVING_MPS
from stucksolver.scene.road import LaneDirection, ZoneKind

MOST_STOPS = 16
"""Maximum number of stops that are checked along a path, evenly spaced: a bound on the work of one check."""


def commit_mask(case: CheckContext) -> Mask:
    """(stations,): True where a stop with comfortable braking ends in, or passes through, a place to keep free.

    Those places are junctions, crosswalks, level crossings, lanes of oncoming traffic, and the border of a lane that
    the path moves into. There the safe option is to finish the path, which has been proven.
    """
    path = case.path
    bad = no_stopping_place(case)
    if not bad.any():
        return bad
    ends = path.s + case.quick.v**2 / (2 * case.view.ego.limits.comfort_braking_mps2)
    last = np.minimum(np.searchsorted(path.s, ends), len(path.s) - 1)
    before = np.concatenate([[0], np.cumsum(bad)])
    result: Mask = before[last + 1] - before[np.arange(len(path.s))] > 0
    return result


def no_stopping_place(case: CheckContext) -> Mask:
    """(stations,): True where a vehicle must not stop."""
    path, half = case.path, case.view.ego.length_m / 2
    tolerance_m = case.policy.lanes.tolerance_m
    bad = np.zeros(len(path.s), dtype=bool)
    for zone in case.view.surroundings.road.zones:
        bad |= (path.s + half > zone.start_m) & (path.s - half < zone.end_m)
    for lane in path.enters:
        if lane is case.start_lane:
            continue
        inside = case.inside(lane).copy()
        if lane.strip.direction is not LaneDirection.OPPOSITE:
            right, left = np.interp(path.s, lane.s, lane.right), np.interp(path.s, lane.s, lane.left)
            inside &= ~((path.d - case.reach > right - tolerance_m) & (path.d + case.reach < left + tolerance_m))
        bad |= inside
    return bad


def are_stops_safe(case: CheckContext, no_stop: Array) -> list[RejectReason]:
    """Check that a stop begun at any instant before the commit point hits no object while the ego is still moving.

    The path keeps clear of stationary objects everywhere. After the ego has stopped in its own lane, others must not
    drive into it.

    Args:
        case: Plan being checked.
        no_stop: (stations,): True where the ego is committed, as returned by `commit_mask`.
    """
    view, policy = case.view, case.policy
    which = relevant(case)
    which = which[view.speed[which] > MOVING_MPS]
    free = np.flatnonzero(~no_stop)
    if not len(which) or not len(free):
        return []
    # The ego follows lead vehicles at its own distance.
    ahead = view.vs[which] > policy.prediction.along_mps
    which = which[~(ahead & (np.abs(view.vd[which]) < policy.prediction.steady_mps))]
    if not len(which):
        return []
    stride = max(int(policy.stopping.every_m / STEP_M), -(-len(free) // MOST_STOPS))
    braking = view.ego.limits.comfort_braking_mps2
    for run in (case.quick, case.slow):
        start = free[::stride]
        lasts = run.v[start] / braking
        t = _instants(case, min(float((run.t[start] + lasts).max()), policy.prediction.horizon_s))
        since = np.clip(t - run.t[start][:, None], 0.0, lasts[:, None])
        driven = np.interp(t, run.t, case.path.s)
        stations = np.where(
            t < run.t[start][:, None],
            driven,
            case.path.s[start][:, None] + run.v[start][:, None] * since - braking * since**2 / 2,
        )
        gap = moving_gaps(case, stations, which, t)
        gap[t > (run.t[start] + lasts)[:, None]] = np.inf
        hit = (gap < 0.0) & (gap < gap[:, :1] - policy.clearance.nearer_m)
        if hit.any():
            when, member = (int(k[0]) for k in np.nonzero(hit)[1:])
            obj = view.objects[int(which[member])]
            detail = f"{obj.kind.value} {obj.id}: contact at {t[when]:.1f} s after an abort"
            return [RejectReason(code=RejectCode.NO_ABORT, detail=detail, object_id=obj.id, time_s=float(t[when]))]
    return []


def is_junction_stop_clear(case: CheckContext, rejects: list[RejectReason], giving_way: bool) -> bool:
    """True if braking now in a junction stays clear of all objects, including crossing traffic that the ego would hit.

    False if the stop ends in an oncoming lane or on a level crossing. If `giving_way`, the ego is already braking.
    """
    view, stopping = case.view, case.policy.stopping
    lasts = stopping.lag_s + view.ego.speed_mps / view.ego.limits.comfort_braking_mps2
    named = {r.object_id: r.time_s for r in rejects if r.time_s is not None}
    met_s = [named[obj.id] for i, obj in enumerate(view.objects) if obj.id in named and goes_straight(case, i)]
    if not met_s or min(met_s) > lasts + (stopping.goes_on_s if giving_way else stopping.gives_way_s):
        return False
    return _may_wait(case, float(braking_profile(case)[0][-1])) and stop_is_clear(case, giving_way)


def stop_is_clear(
    case: CheckContext,
    giving_way: bool,
    braking_mps2: float | None = None,
    least_m: float | None = None,
    lag_s: float | None = None,
) -> bool:
    """True if braking now stays clear of every moving object.

    Args:
        case: Rest of the running plan.
        giving_way: True if the ego is already braking.
        braking_mps2: Deceleration (m/s²); comfortable braking if None.
        least_m: Gap to keep (m); `ClearancePolicy.moving_gap_m` if None.
        lag_s: Time until the brakes act (s); that of the policy if None.
    """
    view, policy = case.view, case.policy
    stations, t = braking_profile(case, braking_mps2, lag_s)
    which = relevant(case, float(t[-1]))
    which = which[view.moving[which]]
    gap = moving_gaps(case, stations[None, :], which, t)[0]
    required = _kept(case, giving_way, policy.clearance.moving_gap_m if least_m is None else least_m)
    return not ((gap < required) & (gap < gap[:1] - policy.clearance.nearer_m)).any()


def stops_beside(case: CheckContext, rejects: list[RejectReason], giving_way: bool) -> bool:
    """True if braking now, with the front in a lane, stays clear of the traffic in that lane that does not yield.

    That traffic is assumed to keep its speed. False on a level crossing, or if the body reaches into an oncoming lane.
    """
    view, policy = case.view, case.policy
    stations, t = braking_profile(case)
    named = {reject.object_id for reject in rejects}
    which = np.array([i for i, obj in enumerate(view.objects) if obj.id in named and view.moving[i]], dtype=int)
    if case.on_rails(float(stations[-1])) or case.in_oncoming_lane or not len(which):
        return False
    gap = moving_gaps(case, stations[None, :], which, t)[0]
    required = np.full(len(which), _kept(case, giving_way, policy.clearance.standing_gap_m))
    uncertainty_m = view.uncertainty_m[which]
    # With uncertain positions, the front may wait nearer to passing traffic than its boxes suggest. That traffic still
    # passes as long as its boxes overlap the ego by no more than the uncertainty. Driving on is the worse option.
    required = np.where(uncertainty_m > 0.0, np.minimum(required, 0.0) - uncertainty_m, required)
    return not (gap < required).any()


def _kept(case: CheckContext, giving_way: bool, gap_m: float) -> float:
    """Return the gap that a stop must leave (m).

    A vehicle that is already braking keeps braking as long as it stops short of the other. A stopped vehicle stays as
    long as no object hits it.
    """
    if not giving_way:
        return gap_m
    return 0.0 if abs(case.view.ego.speed_mps) < MOVING_MPS else min(gap_m, case.policy.harm.touch_m)


def braking_profile(
    case: CheckContext, braking_mps2: float | None = None, lag_s: float | None = None, until_s: float = 0.0
) -> tuple[Array, Array]:
    """Return the ego's arc lengths (m) and the instants (s from now), both (instants,), if it brakes now.

    They run until the ego has been stopped for `StoppingPolicy.stands_s`, and at least until `until_s`.

    Args:
        case: Plan being checked.
        braking_mps2: Deceleration (m/s²); comfortable braking if None.
        lag_s: Time until the brakes act (s); that of the policy if None.
        until_s: Time from now (s).
    """
    braking, speed = braking_mps2 or case.view.ego.limits.comfort_braking_mps2, max(case.view.ego.speed_mps, 0.0)
    stopping = case.policy.stopping
    lag_s = stopping.lag_s if lag_s is None else lag_s
    t = _instants(case, max(lag_s + speed / braking + stopping.stands_s, until_s))
    since = np.clip(t - lag_s, 0.0, speed / braking)
    return case.path.s[0] + speed * np.minimum(t, lag_s) + speed * since - braking * since**2 / 2, t


def _instants(case: CheckContext, end_s: float) -> Array:
    """(instants,): times from now up to the first one at or after `end_s` (s)."""
    step_s = case.policy.prediction.step_s
    result: Array = np.arange(0.0, end_s + step_s, step_s)
    return result


def _may_wait(case: CheckContext, end_s: float) -> bool:
    """True if the stop is in a junction or on a crosswalk, and stays in lanes of the ego's direction."""
    here = case.view.zone_at(float(case.path.s[0]), ZoneKind.JUNCTION, ZoneKind.CROSSWALK)
    if here is None or case.on_rails(end_s):
        return False
    driven = case.path.s <= end_s + case.policy.stopping.past_end_m
    return not any(bool(case.inside(lane)[driven].any()) for lane in case.oncoming_lanes(end_s))
