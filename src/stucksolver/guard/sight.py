"""What is not seen counts as not free, in lanes of our own direction too: ahead as far as a stop takes, and behind."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.case import Case
from stucksolver.guard.policy import rss_distance
from stucksolver.guard.traffic import is_due
from stucksolver.guard.verdict import Reject, RejectCode
from stucksolver.scene.frenet import Lane
from stucksolver.scene.road import LaneDirection, LaneKind

REACTS_S, MARGIN_M = 0.5, 1.0
"""Driving on sight: the way to stop after so long, and so much left before what comes into sight."""
SAMPLED_M = 4.0
"""Sight is looked for every so many metres: what ends nearer to an object, or to a lane's end, ends there."""
SEEN_LATER_S = 1.0
"""Who is further off than they drive in that time before our entry comes into sight while it can still be left be."""
BEHIND_MOST_M = 50.0
"""No more need be seen behind: stacks know about 60 m of their road there."""
CYCLIST_MPS = 6.0
"""Where only cyclists come from behind, at the roadside."""


def seen(case: Case) -> list[Reject]:
    """The ego's lane is seen as far as a stop takes, those it enters also as far back as who comes needs to brake."""
    home = case.start_lane
    if home is None or home.strip.direction is LaneDirection.OPPOSITE:
        return []
    found = _ahead(case, home)
    for lane in case.path.enters:
        if lane.strip.direction is LaneDirection.OPPOSITE or lane is home:
            continue
        inside = np.flatnonzero(case.inside(lane))
        if not len(inside) or not is_due(case, int(inside[0])):
            continue
        if lane.strip.kind is LaneKind.DRIVING:
            found += _ahead(case, lane) + _behind(case, lane, int(inside[0]), _limit(case, lane))
        else:
            found += _behind(case, home, int(inside[0]), CYCLIST_MPS)
    return found[:1]


def _ahead(case: Case, lane: Lane) -> list[Reject]:
    view, limits = case.view, case.view.ego.limits
    speed = float(case.quick.v.max())
    stop_m = speed**2 / (2 * limits.comfort_braking_mps2) + REACTS_S * speed + MARGIN_M
    needed = view.ego.length_m / 2 + min(stop_m, float(case.path.end_s) - view.ego_s)
    have = view.sight_ahead_m(lane)
    if not _beside(case, lane) or have >= needed or _ends(case, lane, view.ego_s + have, +1):
        return []
    return [_unseen(f"sees {have:.0f} m ahead, needs {needed:.0f} m", have - needed)]


def _behind(case: Case, lane: Lane, k: int, speed_mps: float) -> list[Reject]:
    """Could one who comes out of what is not seen still brake behind us when we come in at station `k`?"""
    view = case.view
    when, own = min(float(case.slow.t[k]), SEEN_LATER_S), float(case.slow.v[k])
    gap = speed_mps * when + rss_distance(speed_mps, own, case.policy, running=True)
    needed = view.ego.length_m / 2 + min(gap, BEHIND_MOST_M)
    have = view.sight_behind_m(lane)
    if not _beside(case, lane) or have >= needed or _ends(case, lane, view.ego_s - have, -1):
        return []
    return [_unseen(f"sees {have:.0f} m behind, needs {needed:.0f} m", have - needed)]


def _beside(case: Case, lane: Lane) -> bool:
    """Lanes that begin further on are looked at when the ego is there."""
    return lane.start_m <= case.view.ego_s <= lane.end_m


def _ends(case: Case, lane: Lane, end_s: float, way: int) -> bool:
    """Does the sight end where the lane does, or at something known that is in the lane?"""
    view = case.view
    if way > 0 and end_s > lane.end_m - SAMPLED_M:
        return True
    right, _, left = lane.at(end_s)
    near = view.s - way * view.along
    stands_in = (view.d + view.across > right + 0.5) & (view.d - view.across < left - 0.5)
    return bool((stands_in & (np.abs(near - end_s) <= SAMPLED_M)).any())


def _limit(case: Case, lane: Lane) -> float:
    return lane.strip.speed_limit_mps or case.policy.unknown_oncoming_limit_mps


def _unseen(detail: str, gap_m: float) -> Reject:
    return Reject(code=RejectCode.UNSEEN, detail=detail, gap_m=gap_m)
