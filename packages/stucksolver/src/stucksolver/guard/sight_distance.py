"""Checks sight distances in lanes in the ego's direction: occluded space counts as occupied."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.lane_entry import must_be_proven_now
from stucksolver.guard.rss import rss_distance
from stucksolver.guard.verdict import RejectReason
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet import Lane
from stucksolver.scene.road import LaneDirection, LaneKind


def check_sight_distance(case: CheckContext) -> list[RejectReason]:
    """Check that the sight distance ahead suffices for a stop, and in lanes that the ego enters also the one behind.

    The sight distance behind suffices if traffic from beyond it can brake behind the ego.
    """
    home = case.start_lane
    if home is None or home.strip.direction is LaneDirection.OPPOSITE:
        return []
    rejects = _ahead(case, home)
    for lane in case.path.enters:
        if lane.strip.direction is LaneDirection.OPPOSITE or lane is home:
            continue
        inside = case.first_entries(lane)
        if not len(inside) or not must_be_proven_now(case, int(inside[0])):
            continue
        if lane.strip.kind is LaneKind.DRIVING:
            rejects += _ahead(case, lane) + _behind(case, lane, int(inside[0]), _limit(case, lane))
        else:
            rejects += _behind(case, home, int(inside[0]), case.policy.sight.cyclist_mps)
    return rejects[:1]


def _ahead(case: CheckContext, lane: Lane) -> list[RejectReason]:
    view, limits, policy = case.view, case.view.ego.limits, case.policy.sight
    speed = float(case.quick.v.max())
    stop_m = speed**2 / (2 * limits.comfort_braking_mps2) + policy.reacts_s * speed + policy.margin_m
    needed = view.ego.length_m / 2 + min(stop_m, float(case.path.end_s) - view.ego_s)
    have = view.sight_ahead_m(lane)
    if not _beside(case, lane) or have >= needed or _ends(case, lane, view.ego_s + have, +1):
        return []
    return [_not_visible(f"sight distance ahead {have:.1f} m, required {needed:.1f} m", have - needed)]


def _behind(case: CheckContext, lane: Lane, k: int, speed_mps: float) -> list[RejectReason]:
    """Check that occluded traffic at `speed_mps` (m/s) can still brake if the ego enters at station `k`.

    Traffic that becomes visible while a stop before the entry is possible is detected in time, at any speed.
    """
    view, policy = case.view, case.policy.sight
    stop_s = float(case.quick.v[k]) / (2 * view.ego.limits.comfort_braking_mps2)
    when, own = min(float(case.slow.t[k]), max(policy.seen_later_s, stop_s)), float(case.slow.v[k])
    needed = view.ego.length_m / 2 + speed_mps * when + rss_distance(speed_mps, own, case.policy.rss, running=True)
    have = view.sight_behind_m(lane)
    if not _beside(case, lane) or have >= needed or _ends(case, lane, view.ego_s - have, -1):
        return []
    return [_not_visible(f"sight distance behind {have:.1f} m, required {needed:.1f} m", have - needed)]


def _beside(case: CheckContext, lane: Lane) -> bool:
    """True if the lane is beside the ego. Lanes that begin further on are checked when the ego reaches them."""
    return lane.start_m <= case.view.ego_s <= lane.end_m


def _ends(case: CheckContext, lane: Lane, end_s: float, direction: int) -> bool:
    """True if the sight ends with the lane, or at a known object in the lane. `direction`: +1 ahead, -1 behind."""
    view, policy = case.view, case.policy.sight
    if direction > 0 and end_s > lane.end_m - policy.sampled_m:
        return True
    right, _, left = lane.at(end_s)
    near = view.s - direction * view.along
    # A vehicle beside the ego is passing the end of the sight: a part of it is still ahead, a part behind.
    passing = (np.abs(view.s - end_s) <= view.along) & (
        np.abs(view.s - view.ego_s) <= view.along + view.ego.length_m / 2
    )
    blocks = (np.abs(near - end_s) <= policy.sampled_m) | passing
    stands_in = (view.d + view.across > right + policy.in_lane_m) & (view.d - view.across < left - policy.in_lane_m)
    return bool((stands_in & blocks).any())


def _limit(case: CheckContext, lane: Lane) -> float:
    return lane.strip.speed_limit_mps or case.policy.oncoming.unknown_limit_mps


def _not_visible(detail: str, gap_m: float) -> RejectReason:
    return RejectReason(code=RejectCode.PATH_NOT_VISIBLE, detail=detail, gap_m=gap_m, margin=gap_m, unit="m")
