"""Decides when to yield to predicted traffic: while a stop still keeps the ego's body out of its path.

A fast ego is through a conflict path in a second or two, so it may decide late. A slow ego blocks that path for many
seconds. For it, the last safe stop is due long before the contact, where the conflict path begins.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stucksolver.guard.abort_stops import stop_is_clear
from stucksolver.guard.context import CheckContext
from stucksolver.guard.numerics import stopping_distance_m
from stucksolver.guard.prediction import moving_gaps, profiles, relevant
from stucksolver.guard.verdict import RejectReason
from stucksolver.scene.frenet import Array, Mask
from stucksolver.scene.road import ZoneKind


@dataclass(frozen=True)
class Stop:
    """Stop that begins now.

    Attributes:
        braking_mps2: Deceleration (m/s²).
        lag_s: Longest delay until the brakes act (s).
        way_m: Stopping distance (m).
        least_m: Least gap to a path at the end of the stop (m).
        soonest_m: Stopping distance if the brakes act at once (m).
    """

    braking_mps2: float
    lag_s: float
    way_m: float
    least_m: float
    soonest_m: float


def yields_now(case: CheckContext, rejects: list[RejectReason], giving_way: bool) -> float | None:
    """Return the deceleration that keeps the ego out of all predicted paths (m/s²), if it must brake now.

    None if the ego meets no road user; 0 if it must not brake yet.

    The ego brakes as late as possible, since traffic may turn off before. It must brake now if no later stop, before
    the path of the road user that it meets, ends at a position free of all predicted paths. Such a position may be in a
    junction or on a crossing, but reaches no further into an oncoming lane than a stopped ego may. None also if the ego
    is in a path already: a stop there helps no road user, and `collision_mitigation.least_harmful_option` decides.

    Args:
        case: Rest of the running plan.
        rejects: Predicted contacts.
        giving_way: True if the ego is already braking, or has stopped, for others. It then continues only to a position
            that is further ahead than `StoppingPolicy.yields_ahead_m`.
    """
    stopping, entry, ego = case.policy.stopping, case.policy.entry, case.view.ego
    gained_mps = ego.limits.comfort_acceleration_mps2 * entry.next_look_s
    next_mps, lag_s = max(ego.speed_mps, 0.0) + gained_mps, stopping.lag_s + entry.next_look_s
    next_m = stopping_distance_m(next_mps, ego.limits.comfort_braking_mps2, lag_s)
    if giving_way:
        next_m = max(next_m, stops_from_now(case, giving_way)[0].way_m + stopping.yields_ahead_m)
    return stop_out_of_paths(case, rejects, giving_way, next_m)


def stop_out_of_paths(
    case: CheckContext, rejects: list[RejectReason], giving_way: bool = False, later_m: float = math.inf
) -> float | None:
    """Return the deceleration for a stop that begins now and ends out of all predicted paths (m/s²).

    None if there is no such stop, if the ego meets no moving road user, or if a later stop does as well; 0 if it must
    drive on to a position between two paths.

    Args:
        case: Rest of the running plan.
        rejects: Predicted contacts.
        giving_way: True if the ego is already braking, or has stopped, for others.
        later_m: Least distance at which a later stop ends (m).
    """
    view, clearance = case.view, case.policy.clearance
    times_s = {reject.object_id: reject.time_s for reject in rejects if reject.time_s is not None}
    crosses = view.moving & ~_in_ego_direction(case)
    conflicts = crosses & np.array([o.id in times_s for o in view.objects], dtype=bool)
    if not conflicts.any():
        return None
    until_s = _passed_s(case, max(times_s[view.objects[i].id] for i in np.flatnonzero(conflicts)))
    which = relevant(case, until_s)
    which = which[crosses[which]]
    here, stops = float(case.path.s[0]), stops_from_now(case, giving_way)
    every_m, last_s = case.policy.stopping.place_every_m, here + case.policy.stopping.places_ahead_m
    ahead = np.arange(here, min(last_s, case.path.end_s) + every_m, every_m)
    ends = [here + way_m for stop in stops for way_m in (stop.way_m, stop.soonest_m)]
    places = np.concatenate([ahead, ends])
    gap = _gaps_to_paths(case, places, which, until_s)
    required = np.where(view.vulnerable[which], clearance.vulnerable_gap_m, clearance.moving_gap_m)
    # Missing gap to each path (m), unless the body was beside that path at the same distance already.
    lacks = np.where((gap < gap[0] - clearance.nearer_m) | (gap < 0.0), required - gap, -math.inf)
    meets = np.flatnonzero((lacks[: len(ahead), conflicts[which]] > 0.0).any(axis=1))
    if not len(meets):
        return None
    off_rails, lack = _off_rails(case, places), lacks.max(axis=1, initial=-math.inf)
    beside = _beside_oncoming_lanes(case, places)
    # For a train, a place on the crossing beside its path is better than that path.
    if not all(_comes_on_rails(case, int(i), times_s[view.objects[i].id]) for i in np.flatnonzero(conflicts)):
        beside &= off_rails
    fits = beside[: len(ahead)] & (ahead < ahead[meets[0]]) & (ahead >= here + later_m)
    later = lack[: len(ahead)][fits & ~_enters_junction(case, ahead, here + stops[0].way_m)]
    # The brakes may act at any time up to the stated lag, and the rear may then still be in a path.
    at_stop = lack[len(ahead) :].reshape(-1, 2).max(axis=1)
    left_m: Array = np.where(np.isinf(lacks), math.inf, gap)[len(ahead) :].min(axis=1).reshape(-1, 2).min(axis=1)
    ends_beside = beside[len(ahead) :].reshape(-1, 2)
    tightest_m = clearance.moving_gap_m - case.policy.harm.touch_m
    # If no later position has the full gap, one without contact that is no tighter than the present stop suffices.
    if later.min(initial=math.inf) <= max(0.0, min(float(at_stop[0]), tightest_m)):
        return None
    for k, stop in enumerate(stops):
        # The gap on the way to the stop is no larger than at its end.
        free = left_m[k] >= stop.least_m and bool(ends_beside[k].all())
        if free and stop_is_clear(case, giving_way, stop.braking_mps2, stop.least_m, stop.lag_s):
            return stop.braking_mps2
    # Without a lasting stop, the first contact is avoided first. When no later stop helps, a short one suffices.
    meets_s = min(times_s[view.objects[i].id] for i in np.flatnonzero(conflicts))
    lasts_s, short_s = (
        min(meets_s + more_s, until_s) for more_s in (case.policy.stopping.stands_s, case.policy.rss.reaction_s)
    )
    reachable = ahead[(ahead >= here + later_m) & beside[: len(ahead)]]
    in_lane = [stop for stop, ends in zip(stops, ends_beside, strict=True) if ends.all()]
    tries = [(until_s, in_lane), (lasts_s, in_lane)]
    if ahead[meets[0]] <= here + min(later_m, 2 * stops[0].way_m) + every_m:
        # A stop in an oncoming lane is the last resort.
        tries += [(short_s, in_lane), (short_s, stops[-1:] if off_rails[-2:].all() else [])]
    brakings = (_between_paths(case, reachable, which, span_s, some) for span_s, some in tries)
    return next((braking for braking in brakings if braking is not None), None)


def _between_paths(case: CheckContext, places: Array, which: Array, until_s: float, stops: list[Stop]) -> float | None:
    """Return the deceleration for a stop in a path that is free of traffic during the stop (m/s²).

    No position is free of all paths. Some are free while the ego is stopped there: between two vehicles that cross one
    after the other. 0 if the ego can still drive on to such a position; None if neither that nor a stop now avoids a
    contact.

    Args:
        case: Rest of the running plan.
        places: Arc lengths to which the ego may drive on (m).
        which: Indices of the crossing road users.
        until_s: Duration of the stop (s from now).
        stops: Stops that can begin now.
    """
    step_s, here = case.policy.prediction.step_s, float(case.path.s[0])
    t = np.arange(0.0, until_s + step_s, step_s)
    reachable = profiles(case, t)
    waits = np.minimum(reachable, places[:, None, None]) if len(places) else np.zeros((0, *reachable.shape))
    if _untouched(case, waits, which, t, case.policy.harm.touch_m).any():
        return 0.0
    for stop in stops:
        ends = here + np.array([stop.soonest_m, stop.way_m])
        if _untouched(case, np.minimum(reachable[-1:], ends[:, None, None]), which, t, stop.least_m).all():
            return stop.braking_mps2
    return None


def _untouched(case: CheckContext, stations: Array, which: Array, t: Array, least_m: float) -> Mask:
    """(places,): True if no road user comes nearer than `least_m` to the ego.

    The ego is at `stations` (places, profiles, instants) (m) at the instants `t` (s).
    """
    gap = moving_gaps(case, stations.reshape(-1, len(t)), which, t)
    hit = (gap < least_m) & (gap < gap[:, :1] - case.policy.clearance.nearer_m)
    touched: Mask = hit.any(axis=(1, 2)).reshape(stations.shape[:2])
    return np.asarray(~touched.any(axis=1))


def stops_from_now(case: CheckContext, giving_way: bool) -> list[Stop]:
    """Return the stops that can begin now: gentle and hard, the best first.

    If the ego already yields, its brakes may act already or not yet: the longer distance counts first.
    """
    limits, speed = case.view.ego.limits, max(case.view.ego.speed_mps, 0.0)
    levels = ((limits.comfort_braking_mps2, case.policy.harm.touch_m), (limits.max_braking_mps2, 0.0))
    lags_s = (case.policy.stopping.lag_s, 0.0) if giving_way else (case.policy.stopping.lag_s,)
    return [
        Stop(level, lag_s, stopping_distance_m(speed, level, lag_s), least_m, stopping_distance_m(speed, level, 0.0))
        for lag_s in lags_s
        for level, least_m in levels
    ]


def _in_ego_direction(case: CheckContext) -> Mask:
    """(objects,): True for vehicles that drive along a lane in the ego's direction.

    They fall back behind the ego, or the ego behind them. `lane_entry` and `adjacent_traffic` check them, not their
    predicted paths.
    """
    view, policy = case.view, case.policy.prediction
    steady = (view.vs > policy.along_mps) & (np.abs(view.vd) < policy.steady_mps)
    result: Mask = steady & view.on_lane & ~view.elsewhere & ~view.on_foot
    return result


def _passed_s(case: CheckContext, contact_s: float) -> float:
    """Return when the ego has waited for a contact to pass and has driven the rest of its path (s from now)."""
    end_s = contact_s + case.policy.stopping.stands_s + case.slow.duration_s
    return min(end_s, case.policy.prediction.horizon_s)


def _beside_oncoming_lanes(case: CheckContext, stations: Array) -> Mask:
    """(stations,): True where the body reaches no further into an oncoming lane than a stopped ego may."""
    d, reach = (np.interp(stations, case.path.s, row) for row in (case.path.d, case.reach))
    result: Mask = np.ones(len(stations), dtype=bool)
    for lane in case.oncoming_lanes(float(stations.max())):
        right, left = (np.interp(stations, lane.s, row) for row in (lane.right, lane.left))
        result &= np.minimum(d + reach - right, left - d + reach) <= case.policy.lanes.standing_edge_m
    return result


def _comes_on_rails(case: CheckContext, i: int, contact_s: float) -> bool:
    """True if object `i` crosses the ego's road on a level crossing that the ego is on, as a train does."""
    view, half, here = case.view, case.view.ego.length_m / 2, float(case.path.s[0])
    s = float(view.s[i] + view.vs[i] * contact_s)
    return any(
        zone.kind is ZoneKind.LEVEL_CROSSING
        and zone.start_m < here + half
        and here - half < zone.end_m
        and zone.start_m < s < zone.end_m
        for zone in view.surroundings.road.zones
    )


def _off_rails(case: CheckContext, stations: Array) -> Mask:
    """(stations,): True where no part of the body is on a level crossing."""
    half = case.view.ego.length_m / 2
    result: Mask = np.ones(len(stations), dtype=bool)
    for zone in case.view.surroundings.road.zones:
        if zone.kind is ZoneKind.LEVEL_CROSSING:
            result &= (stations + half < zone.start_m) | (stations - half > zone.end_m)
    return result


def waits_outside(case: CheckContext) -> bool:
    """True if the ego has stopped, and its front is no further inside a junction than the nearest lane."""
    ego, policy = case.view.ego, case.policy.stopping
    nose, rear = float(case.path.s[0]) + ego.length_m / 2, float(case.path.s[0]) - ego.length_m / 2
    inside = (
        zone.kind is ZoneKind.JUNCTION and zone.start_m + policy.nose_in_junction_m < nose and rear < zone.end_m
        for zone in case.view.surroundings.road.zones
    )
    return abs(ego.speed_mps) < policy.rests_mps and not any(inside)


def _enters_junction(case: CheckContext, stations: Array, stop_m: float) -> Mask:
    """(stations,): True where the body is further inside a junction than if it stops at `stop_m` (m).

    Traffic that is not visible yet may come along any lane there. It makes no difference for a front that is already
    beyond the nearest lane at the stop.
    """
    half, nose_m = case.view.ego.length_m / 2, case.policy.stopping.nose_in_junction_m
    result: Mask = np.zeros(len(stations), dtype=bool)
    for zone in case.view.surroundings.road.zones:
        if zone.kind is ZoneKind.JUNCTION and stop_m + half <= zone.start_m + nose_m:
            result |= (stations + half > max(zone.start_m, stop_m + half)) & (stations - half < zone.end_m)
    return result


def _gaps_to_paths(case: CheckContext, stations: Array, which: Array, until_s: float) -> Array:
    """(stations, objects): smallest gap between the ego's stopped body there and an object's predicted path (m)."""
    step_s = case.policy.prediction.step_s
    t = np.arange(0.0, until_s + step_s, step_s)
    rests = np.repeat(stations[:, None], len(t), axis=1)
    result: Array = moving_gaps(case, rests, which, t).min(axis=1)
    return result
