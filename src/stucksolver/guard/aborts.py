"""Where a stop is a safe way out of a path, and the proof that it is."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.case import Case
from stucksolver.guard.predict import moving_gaps, relevant
from stucksolver.guard.verdict import Reject, RejectCode
from stucksolver.scene.frenet import Array
from stucksolver.scene.road import LaneDirection
from stucksolver.scene.view import MOVING_MPS

EVERY_M = 3.0
MOST_STOPS = 16
STEP_S = 0.2
GIVES_WAY_S, STANDS_S = 2.5, 3.0
"""Way is given to those who would be met within so long after a stop; the stop is looked at for so long."""


def committed(case: Case) -> Array:
    """At which stations a stop by comfortable braking may end, or pass through, where no vehicle should stand.

    Those places are junctions, crosswalks and level crossings; lanes of the oncoming traffic; and the border of a
    lane that the path moves into. There the way out is to finish, which has been proven.
    """
    path = case.path
    bad = _no_place(case)
    if not bad.any():
        return bad
    ends = path.s + case.quick.v**2 / (2 * case.view.ego.limits.comfort_braking_mps2)
    last = np.minimum(np.searchsorted(path.s, ends), len(path.s) - 1)
    before = np.concatenate([[0], np.cumsum(bad)])
    result: Array = before[last + 1] - before[np.arange(len(path.s))] > 0
    return result


def _no_place(case: Case) -> Array:
    path, half = case.path, case.view.ego.length_m / 2
    bad = np.zeros(len(path.s), dtype=bool)
    for zone in case.view.surroundings.road.zones:
        bad |= (path.s + half > zone.start_m) & (path.s - half < zone.end_m)
    for lane in path.enters:
        if lane is case.start_lane:
            continue
        inside = case.inside(lane) > 0
        if lane.strip.direction is not LaneDirection.OPPOSITE:
            right, left = np.interp(path.s, lane.s, lane.right), np.interp(path.s, lane.s, lane.left)
            inside &= ~((path.d - case.reach > right - 0.1) & (path.d + case.reach < left + 0.1))
        bad |= inside
    return bad


def stops_are_safe(case: Case, no_stop: Array) -> list[Reject]:
    """From each instant before the commit point, a stop on the path meets nobody while the ego still moves.

    What stands is kept clear of all along the path; once the ego stands in its own lane, others must not drive into it.
    """
    view = case.view
    which = relevant(case)
    which = which[np.hypot(view.vs[which], view.vd[which]) > MOVING_MPS]
    free = np.flatnonzero(~no_stop)
    if not len(which) or not len(free):
        return []
    # Those ahead of us in our own direction are followed at their own distance.
    which = which[~((view.vs[which] > 0.5) & (np.abs(view.vd[which]) < 0.5))]
    if not len(which):
        return []
    stride = max(int(EVERY_M / 0.5), -(-len(free) // MOST_STOPS))
    braking = view.ego.limits.comfort_braking_mps2
    for run in (case.quick, case.slow):
        start = free[::stride]
        lasts = run.v[start] / braking
        t = np.arange(0.0, min(float((run.t[start] + lasts).max()), case.policy.horizon_s) + STEP_S, STEP_S)
        since = np.clip(t - run.t[start][:, None], 0.0, lasts[:, None])
        driven = np.interp(t, run.t, case.path.s)
        stations = np.where(
            t < run.t[start][:, None],
            driven,
            case.path.s[start][:, None] + run.v[start][:, None] * since - braking * since**2 / 2,
        )
        gap = moving_gaps(case, stations, which, t)
        gap[t > (run.t[start] + lasts)[:, None]] = np.inf
        hit = (gap < 0.0) & (gap < gap[:, :1] - 0.05)
        if hit.any():
            when, who = (int(k[0]) for k in np.nonzero(hit)[1:])
            thing = view.objects[int(which[who])]
            detail = f"{thing.kind.value} {thing.id} would be met by stopping after {t[when]:.1f} s"
            return [Reject(code=RejectCode.NO_ABORT, detail=detail, object_id=thing.id, time_s=float(t[when]))]
    return []


def lets_by(case: Case, rejects: list[Reject]) -> bool:
    """Does braking now keep clear of everybody, of those too whom going on would meet before long?"""
    met_s = [reject.time_s for reject in rejects if reject.time_s is not None]
    braking, speed = case.view.ego.limits.comfort_braking_mps2, case.view.ego.speed_mps
    lasts = speed / braking
    if not met_s or min(met_s) > lasts + GIVES_WAY_S:
        return False
    which = relevant(case)
    t = np.arange(0.0, lasts + STANDS_S + STEP_S, STEP_S)
    since = np.minimum(t, lasts)
    stations = case.path.s[0] + speed * since - braking * since**2 / 2
    gap = moving_gaps(case, stations[None, :], which, t)[0]
    return not ((gap < 0.0) & (gap < gap[:1] - 0.05)).any()
