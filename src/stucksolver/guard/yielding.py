"""Decides when to yield to predicted traffic: while a stop still keeps the ego's body out of its path.

A fast ego is through another's path in a second or two, so it may decide late. A slow ego lies across that path for
many seconds. For it, the last safe stop is due long before the contact, where the other's path begins.
"""

from __future__ import annotations

import math

import numpy as np

from stucksolver.guard.aborts import stop_is_clear
from stucksolver.guard.context import CheckContext
from stucksolver.guard.numerics import way_to_stop
from stucksolver.guard.predict import moving_gaps
from stucksolver.guard.verdict import Reject
from stucksolver.scene.frenet import Array

STATION_M = 0.25
"""Distance between the places at which the body is compared with a path (m): less than half of any gap to keep."""


def yields_now(case: CheckContext, rejects: list[Reject], giving_way: bool) -> bool:
    """True if the ego must brake now so that it does not come to lie in the path of traffic that it would meet.

    It brakes as late as that allows, since traffic may turn off before. It stops wherever that path is free of it, also
    in a junction or on a crossing, but no further into an oncoming lane than a stopped ego may reach. False if the ego
    is in that path already: a stop there helps nobody, and `ways_out.least_harm` decides.

    Args:
        case: The rest of the running plan.
        rejects: The predicted contacts.
        giving_way: The ego is already braking, or has stopped, for others. It then continues only if that path begins
            further ahead than `StoppingPolicy.yields_ahead_m`.
    """
    stopping, entry, ego = case.policy.stopping, case.policy.entry, case.view.ego
    gained_mps = ego.limits.comfort_acceleration_mps2 * entry.next_look_s
    next_mps, lag_s = max(ego.speed_mps, 0.0) + gained_mps, stopping.lag_s + entry.next_look_s
    last_m = way_to_stop(next_mps, ego.limits.comfort_braking_mps2, lag_s)
    if giving_way:
        last_m = max(last_m, _stopping_m(case, giving_way) + stopping.yields_ahead_m)
    # The last stop is also due before the body reaches into an oncoming lane, wherever in it the other is met.
    may_stop_later = _may_stop_beside_oncoming_lanes(case, float(case.path.s[0]) + last_m)
    return stop_keeps_paths_free(case, rejects, giving_way, last_m if may_stop_later else math.inf)


def stop_keeps_paths_free(
    case: CheckContext, rejects: list[Reject], giving_way: bool = False, within_m: float = math.inf
) -> bool:
    """True if a stop that begins now keeps the body out of the paths of those whom the ego would meet.

    Args:
        case: The rest of the running plan.
        rejects: The predicted contacts.
        giving_way: The ego is already braking, or has stopped, for others.
        within_m: Only paths that begin within this distance count (m).
    """
    view = case.view
    times_s = {reject.object_id: reject.time_s for reject in rejects if reject.time_s is not None}
    met = np.array([i for i, thing in enumerate(view.objects) if thing.id in times_s and view.moving[i]], dtype=int)
    here = float(case.path.s[0])
    stop_s, last_s = here + _stopping_m(case, giving_way), min(here + within_m, case.path.end_s)
    if not len(met) or not _may_stop_beside_oncoming_lanes(case, stop_s):
        return False
    stations = np.array([stop_s, *np.arange(here, last_s + STATION_M, STATION_M)])
    gap = _gaps_to_paths(case, stations, met, max(times_s[view.objects[int(i)].id] for i in met))
    kept = np.where(view.vulnerable[met], case.policy.clearance.vulnerable_gap_m, case.policy.clearance.moving_gap_m)
    enters = (gap[1:] < kept) & (gap[1:] < gap[1] - case.policy.clearance.nearer_m)
    at_stop = gap[0, enters.any(axis=0)]
    return bool(len(at_stop) and at_stop.min() >= case.policy.harm.touch_m) and stop_is_clear(case, giving_way)


def _stopping_m(case: CheckContext, giving_way: bool) -> float:
    """Return the distance of a comfortable stop that begins now (m)."""
    ego = case.view.ego
    lag_s = 0.0 if giving_way else case.policy.stopping.lag_s
    return way_to_stop(max(ego.speed_mps, 0.0), ego.limits.comfort_braking_mps2, lag_s)


def _may_stop_beside_oncoming_lanes(case: CheckContext, stop_s: float) -> bool:
    """True if the body, stopped at `stop_s` (m), reaches no further into an oncoming lane than a stopped ego may."""
    d, reach = (float(np.interp(stop_s, case.path.s, row)) for row in (case.path.d, case.reach))
    for lane in case.oncoming_lanes(stop_s):
        right, left = (float(np.interp(stop_s, lane.s, row)) for row in (lane.right, lane.left))
        if min(d + reach - right, left - d + reach) > case.policy.lanes.standing_edge_m:
            return False
    return True


def _gaps_to_paths(case: CheckContext, stations: Array, met: Array, until_s: float) -> Array:
    """(stations, objects): smallest gap between the ego's body at rest there and an object's whole predicted path (m).

    The path reaches from the object's present place to where it is `StoppingPolicy.stands_s` after the predicted
    contact at `until_s` (s).
    """
    step_s = case.policy.prediction.step_s
    t = np.arange(0.0, until_s + case.policy.stopping.stands_s + step_s, step_s)
    rests = np.repeat(stations[:, None], len(t), axis=1)
    result: Array = moving_gaps(case, rests, met, t).min(axis=1)
    return result
