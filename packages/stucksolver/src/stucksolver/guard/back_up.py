"""Checks the sight behind an ego that backs up: stacks do not watch that direction."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.collision_mitigation import hard_braking_mps2
from stucksolver.guard.context import CheckContext
from stucksolver.guard.leaving import places_left
from stucksolver.guard.numerics import stopping_distance_m
from stucksolver.guard.rss import rss_distance
from stucksolver.guard.verdict import RejectReason, Verdict
from stucksolver.plan.behaviors import AbortAction
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet import Lane
from stucksolver.scene.objects import MOTOR_VEHICLES


def check_lane_visible(case: CheckContext) -> list[RejectReason]:
    """Check that the lane is visible for the whole path plus a margin."""
    lane = case.start_lane
    sight_m = 0.0 if lane is None else case.view.sight_ahead_m(lane)
    needed = case.path.end_s - case.view.ego_s + case.view.ego.length_m / 2 + _margin_m(case, lane, sight_m)
    if sight_m >= needed - (case.policy.backing.look_m if case.running else 0.0):
        return []
    return [_not_visible(f"sight distance {sight_m:.1f} m, required {needed:.1f} m for the path", sight_m - needed)]


def must_stop(case: CheckContext, off: RejectReason | None) -> Verdict | None:
    """Return the verdict that stops an ego past the commit point, even in a place to keep free; None to back up.

    Off its path (`off`), the ego backs up where nothing was proven, and the plan ends. It pauses while it does not see
    as far as it needs for a stop. The rest of the path need not be visible.
    """
    if off is not None:
        return Verdict(rejects=(off,), abort=AbortAction.STOP, brake_mps2=hard_braking_mps2(case))
    lane, ego, backing = case.start_lane, case.view.ego, case.policy.backing
    sight_m = 0.0 if lane is None else case.view.sight_ahead_m(lane)
    stop_m = stopping_distance_m(abs(ego.speed_mps), ego.limits.comfort_braking_mps2, case.policy.stopping.lag_s)
    needed = ego.length_m / 2 + min(stop_m, case.path.end_s - case.view.ego_s) + backing.closed_margin_m
    if sight_m >= needed - backing.look_m:
        return None
    unseen = _not_visible(f"sight distance {sight_m:.1f} m, required {needed:.1f} m for a stop", sight_m - needed)
    return Verdict(rejects=(unseen,), abort=AbortAction.YIELD)


def _margin_m(case: CheckContext, lane: Lane | None, sight_m: float) -> float:
    """Return the sight distance required beyond the path (m).

    An ego that backs up further than for a recovery may come near traffic that is not in sight yet. Traffic at the
    limit of the lane must then be able to stop behind it, by Lemma 2. This does not count the way out of a place where
    the ego must not stand: staying there is worse.
    """
    policy = case.policy.backing
    if lane is not None and _closed(case, lane, sight_m):
        return policy.closed_margin_m
    half = case.view.ego.length_m / 2
    begins = max([case.start_s, *(place.end_m + half for place in places_left(case))])
    if case.path.end_s - begins <= policy.far_m:
        return policy.margin_m
    limit = (lane.strip.speed_limit_mps if lane else None) or case.policy.oncoming.unknown_limit_mps
    return max(policy.margin_m, rss_distance(limit, 0.0, case.policy.rss, running=True))


def _closed(case: CheckContext, lane: Lane, seen_m: float) -> bool:
    """True if the sight in a lane ends at a stopped vehicle that fills it, and the ego only creeps toward it."""
    view, policy = case.view, case.policy.backing
    standing = ~view.moving & (view.s > view.ego_s)
    nearer = view.s - view.along - view.ego_s
    if float(case.path.speed.max()) > policy.gentle_mps:
        return False
    ends_m = policy.sight_ends_m + (policy.look_m if case.running else 0.0)
    for i in np.flatnonzero(standing & (np.abs(nearer - seen_m) < ends_m)):
        right, _, left = lane.at(float(view.s[i]))
        gap_m = max(view.d[i] - view.across[i] - right, left - view.d[i] - view.across[i])
        apart_m = np.hypot(view.s - view.s[i], view.d - view.d[i]) - view.along[i]
        people = view.vulnerable & (apart_m < policy.people_m)
        if gap_m < policy.beside_m and not people.any() and view.objects[int(i)].kind in MOTOR_VEHICLES:
            return True
    return False


def _not_visible(detail: str, gap_m: float) -> RejectReason:
    return RejectReason(code=RejectCode.PATH_NOT_VISIBLE, detail=detail, gap_m=gap_m, margin=gap_m, unit="m")
