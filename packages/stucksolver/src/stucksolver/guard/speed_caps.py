"""Speed caps: the limits of the lanes, low in a recovery, higher for a pass or a request without people alongside."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.numerics import EPSILON
from stucksolver.guard.path_tracking import tracked_path
from stucksolver.guard.policy import GuardPolicy
from stucksolver.guard.prediction import stationary_gaps
from stucksolver.guard.verdict import RejectReason
from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.scene.boxes import separation
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet import Array, Lane, Mask
from stucksolver.scene.frenet_scene import MOVING_MPS, FrenetScene
from stucksolver.scene.objects import VEHICLES, ObjectKind, TrackedObject
from stucksolver.scene.road import LaneDirection, LaneKind

DOORED = frozenset({ObjectKind.CAR, ObjectKind.VAN, ObjectKind.TRUCK, ObjectKind.EMERGENCY})
"""Kinds of vehicles with side doors that may open into traffic."""


def cap_mps(case: CheckContext) -> float:
    """Return the highest speed of a plan where the limits of its lanes allow it (m/s).

    A pass through the oncoming lane past stationary objects may be faster than a recovery, because a shorter pass meets
    less traffic. So may overtaking at a passenger's request. Neither holds beside people, within reach of a car door,
    or across a solid line (see `marking`).
    """
    speeds = case.policy.speeds
    allowed = [speeds.guided_mps] if case.guided else []
    borrowed = any(lane.strip.direction is LaneDirection.OPPOSITE for lane in case.path.enters)
    if borrowed and case.path.passes and not _passes_moving_object(case):
        allowed.append(speeds.passing_mps)
    if not allowed or _object_beside(case) is not None:
        return speeds.recovery_mps
    return max(*allowed, speeds.recovery_mps)


def limits_mps(case: CheckContext) -> Array:
    """(stations,): lowest speed limit of the lanes that the body is in (m/s); infinite off all lanes.

    A lane without a known limit has that of a recovery. A limit is never below walking pace.
    """
    half_m, s = case.view.ego.length_m / 2, case.path.s
    limits = np.full(len(s), np.inf)
    for lane in case.view.frame.lanes:
        limit = _limit_mps(lane, case.policy)
        beside = (s + half_m > lane.start_m) & (s - half_m < lane.end_m)
        if limit is not None and beside.any():
            limits[beside & case.inside(lane)] = np.minimum(limits[beside & case.inside(lane)], limit)
    return limits


def _limit_mps(lane: Lane, policy: GuardPolicy) -> float | None:
    limit_mps, speeds = lane.strip.speed_limit_mps, policy.speeds
    if limit_mps is None:
        return speeds.recovery_mps if lane.strip.kind is LaneKind.DRIVING else None
    # The arguments are in this order so that a limit that is not a number counts as walking pace.
    return max(speeds.creep_mps, limit_mps)


def within_limits(path: FrenetPath, view: FrenetScene, policy: GuardPolicy, *, reverse: bool) -> FrenetPath:
    """Return a path slowed for doors, and to the limits of its lanes where it is no faster than a recovery.

    Behaviors request recovery speed without regard to the limits. A plan that requests more must respect the limits,
    and is rejected above them (`check_speed_cap`).
    """
    case = CheckContext(view, tracked_path(path, view, policy.tracking, reverse=reverse), policy)
    slow = path.speed <= policy.speeds.recovery_mps + EPSILON
    return path.no_quicker(np.minimum(np.where(slow, limits_mps(case), np.inf), _beside_doors_mps(case, slow)))


def drawn_to_doors(case: CheckContext, speed: Array) -> Array:
    """(stations,): distance beside the reach of a door that the ego needs at each `speed` (stations,) (m).

    A tracking fault moves the body sideways until hard braking has slowed it to walking pace. Before the start, the
    distance also covers the error that counts as none.
    """
    tracking, limits = case.policy.tracking, case.view.ego.limits
    slows_s = np.maximum(speed - case.policy.speeds.creep_mps, 0.0) / limits.max_braking_mps2
    room_m: Array = tracking.drift_mps * (case.policy.stopping.lag_s + slows_s)
    return room_m if case.running else room_m + tracking.beside_m


def brakes_for_door(case: CheckContext, rejects: list[RejectReason]) -> float | None:
    """Return the deceleration before the reach of a door (m/s²), as in `drawn_to_doors`; None without a door."""
    near = any(reject.code is RejectCode.DOOR for reject in rejects)
    return case.view.ego.limits.max_braking_mps2 if near else None


def _beside_doors_mps(case: CheckContext, slow: Mask) -> Array:
    """(stations,): highest speed for which the distance to the doors of parked vehicles suffices (m/s).

    Infinite away from doors, and too near to them: within their reach a plan above walking pace is rejected, and within
    `SpeedPolicy.doors_aside_m` a plan above recovery speed, where not `slow` (stations,).
    """
    view, doors, tracking = case.view, case.policy.doors, case.policy.tracking
    fastest = np.full(len(case.path.s), np.inf)
    which = np.array(
        [i for i, o in enumerate(view.objects) if view.speed[i] <= MOVING_MPS and may_open(o, doors.parked_s)],
        dtype=int,
    )
    if not len(which):
        return fastest
    reach = stationary_gaps(case, which, aside_m=doors.reach_m, part=doors.part_of_length)
    slows_s = np.maximum((reach - tracking.beside_m) / tracking.drift_mps - case.policy.stopping.lag_s, 0.0)
    allowed = case.policy.speeds.creep_mps + view.ego.limits.max_braking_mps2 * slows_s
    aside_m = case.policy.speeds.doors_aside_m + case.policy.clearance.nearer_m
    least_m = np.where(slow, 0.0, aside_m - doors.reach_m)
    counts = (reach >= least_m[:, None]) & (reach < reach[0] - case.policy.clearance.nearer_m)
    result: Array = np.where(counts, allowed, np.inf).min(axis=1)
    return result


def may_open(obj: TrackedObject, parked_s: float) -> bool:
    """True for a vehicle with doors that has parked."""
    return obj.kind in DOORED and (obj.stationary_s is None or obj.stationary_s >= parked_s)


def check_speed_cap(case: CheckContext) -> RejectReason | None:
    """Return the reject reason for a speed above the plan's cap or the limit of a lane; None if there is none."""
    speeds, requested = case.policy.speeds, case.path.speed
    limits = limits_mps(case)
    over: Mask = requested > limits + EPSILON
    if over.any():
        k = int(np.where(over, requested - limits, -np.inf).argmax())
        away = case.path.s[k] - case.path.s[0]
        detail = f"speed {requested[k]:.1f} m/s exceeds the limit of {limits[k]:.1f} m/s {away:.0f} m ahead"
        margin_mps = float(limits[k] - requested[k])
        return RejectReason(code=RejectCode.OVERSPEED, detail=detail, margin=margin_mps, unit="m/s")
    most = float(requested.max())
    if most <= speeds.recovery_mps + EPSILON or most <= (cap := cap_mps(case)) + EPSILON:
        return None
    beside = _object_beside(case)
    why = "" if beside is None else f" beside {case.view.objects[beside].kind.value} {case.view.objects[beside].id}"
    detail = f"speed {most:.1f} m/s exceeds the cap of {cap:.1f} m/s{why}"
    return RejectReason(code=RejectCode.OVERSPEED, detail=detail, margin=cap - most, unit="m/s")


def _passes_moving_object(case: CheckContext) -> bool:
    return any(o.id in case.path.passes and case.view.moving[i] for i, o in enumerate(case.view.objects))


def _object_beside(case: CheckContext) -> int | None:
    """Return the index of a person, two-wheeler or car door within reach of an ego above recovery speed.

    None if there is none. While the plan runs, tracking errors may use up a part of the distance, as of every gap.
    """
    view, speeds = case.view, case.policy.speeds
    quick: Mask = case.quick.v > speeds.recovery_mps + EPSILON
    if not quick.any():
        return None
    people = np.flatnonzero(view.vulnerable | view.two_wheeled)
    doored = np.array([o.kind in VEHICLES for o in view.objects], dtype=bool) & ~view.moving & ~view.two_wheeled
    doors = np.flatnonzero(doored & ~view.vulnerable)
    used_m = case.policy.clearance.tracked_gap_m if case.running else 0.0
    aside_m, part = speeds.doors_aside_m - used_m, case.policy.doors.part_of_length
    for which, gaps in (
        (people, _gaps_on_the_way(case, people, speeds.people_aside_m - used_m)),
        (doors, stationary_gaps(case, doors, aside_m=aside_m, part=part)),
    ):
        if len(which) and (gap := gaps[quick].min(axis=0)).min() < 0.0:
            return int(which[int(gap.argmin())])
    return None


def _gaps_on_the_way(case: CheckContext, which: Array, aside_m: float) -> Array:
    """(stations, objects): gaps to objects, widened by `aside_m` (m), while the ego passes (m).

    While the ego, sluggish or fast, is at a station, an object that keeps its velocity sweeps a part of its path. A
    pedestrian may also stay.
    """
    view = case.view
    now = np.where(view.on_foot[which], stationary_gaps(case, which, aside_m=aside_m), np.inf)
    middle_s = ((case.slow.t + case.quick.t) / 2)[:, None]
    half_s = (np.abs(case.slow.t - case.quick.t) / 2)[:, None]
    swept = separation(
        (case.path.s[:, None], case.path.d[:, None], case.heading[:, None]),
        (view.ego.length_m / 2, view.ego.width_m / 2),
        (view.s[which] + view.vs[which] * middle_s, view.d[which] + view.vd[which] * middle_s, 0.0),
        (
            view.along[which] + np.abs(view.vs[which]) * half_s,
            view.across[which] + np.abs(view.vd[which]) * half_s + aside_m,
        ),
    )
    # A path that is laid out at exactly this distance keeps it.
    return np.minimum(now, swept) + EPSILON
