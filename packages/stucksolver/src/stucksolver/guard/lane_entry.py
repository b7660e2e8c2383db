"""Checks traffic in the ego's direction in the lanes that a plan enters: ahead and from behind."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.numerics import EPSILON, stopping_distance_m
from stucksolver.guard.rss import rss_distance
from stucksolver.guard.verdict import RejectReason
from stucksolver.plan.speed_profile import SpeedProfile
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet import Array, Lane, Mask
from stucksolver.scene.frenet_scene import MOVING_MPS
from stucksolver.scene.objects import TrackedObject
from stucksolver.scene.road import LaneDirection

GivingWay = bool | frozenset[str]
"""Vehicles to which the last abort of a running plan yielded: their ids; True for all vehicles, False for none."""


def lane_entry(case: CheckContext) -> list[RejectReason]:
    """Check the RSS distances to traffic ahead and behind in the ego's direction when the body enters each lane.

    This includes an oncoming lane, in which a follower may already be passing the ego. While a plan runs, an entry that
    is further ahead than a stop needs is decided later, because the gap in traffic changes until then.
    """
    rejects: list[RejectReason] = []
    home = case.start_lane
    for lane in case.path.enters:
        inside = case.first_entries(lane)
        if len(inside) and must_be_proven_now(case, int(inside[0])):
            rejects += _entry(case, lane, int(inside[0]))
    if case.path.returns and home is not None and home not in case.path.enters:
        # The return is where the body re-enters its own lane for the last time.
        back = case.entries(home)
        if len(back) and must_be_proven_now(case, int(back[-1])):
            rejects += _entry(case, home, int(back[-1]))
    return rejects


def must_be_proven_now(case: CheckContext, k: int) -> bool:
    """True if the entry at station `k` must be safe now: before the start, and whenever an oncoming lane is used."""
    if not case.running or any(lane.strip.direction is LaneDirection.OPPOSITE for lane in case.path.enters):
        return True
    policy = case.policy.entry
    return float(case.path.s[k] - case.path.s[0]) < _stop_m(case, policy.decides_s) + policy.decides_m


def _stop_m(case: CheckContext, later_s: float) -> float:
    """Return the ego's stopping distance if it brakes after a delay `later_s` (m)."""
    return stopping_distance_m(case.view.ego.speed_mps, case.view.ego.limits.comfort_braking_mps2, later_s)


def _entry(case: CheckContext, lane: Lane, k: int) -> list[RejectReason]:
    view, tolerance_m = case.view, case.policy.lanes.tolerance_m
    right, _, left = lane.at(float(case.path.s[k]))
    borrowed = lane.strip.direction is LaneDirection.OPPOSITE
    tail = _tail(case, lane, k)
    for i, obj in enumerate(view.objects):
        if view.vs[i] < case.policy.prediction.along_mps or not case.traffic[i]:
            continue
        if borrowed and obj.id in case.path.passes:
            continue
        if view.d[i] + view.across[i] <= right + tolerance_m or view.d[i] - view.across[i] >= left - tolerance_m:
            continue
        reject = check_entry_gap(case, k, i, tail)
        if reject is not None:
            return [reject]
    return []


def check_rear_traffic_can_stop(case: CheckContext, giving_way: GivingWay) -> list[RejectReason]:
    """Check traffic from behind that can no longer stop if it reacts only when the ego enters its path.

    A driver who enters a lane with the RSS distances expects others to react when the lane's border is crossed. Some
    drivers brake only for objects directly ahead. For these the border is where their own body will pass, and until
    then the ego can stop beside them. They watch the ego, so half the reaction time is enough. The full time is used
    before the ego continues ahead of a vehicle to which it yields (`giving_way`). After that vehicle has passed, the
    next one counts as watching.
    """
    view, path, policy = case.view, case.path, case.policy.entry
    coming = (view.vs > MOVING_MPS) & case.traffic & ~view.elsewhere
    behind = np.flatnonzero(coming & (view.s - view.along < view.ego_front_s))
    # The nearest vehicle comes first: while the ego yields to it, no vehicle behind it is named in the verdict.
    for i in behind[np.argsort(-view.s[behind], kind="stable")]:
        on_left = bool(view.d[i] > path.d[0])
        edge = float(view.d[i]) + (-1.0 if on_left else 1.0) * float(view.across[i])
        inside = path.d + case.reach - edge if on_left else edge - path.d + case.reach
        # Passing traffic needs its gap, and drivers who react only to their own path must be able to stop. If the front
        # is already in the gap that one vehicle needed to pass, the next ones must still be able to stop. With
        # uncertain positions, the front may seem to be in their path while it is only beside it.
        uncertainty_m = case.uncertainty_m(int(i))
        least = (0.0, -uncertainty_m) if uncertainty_m > 0.0 else (0.0,)
        borders = [(beside_m, inside > -beside_m) for beside_m in (policy.beside_m, *least)]
        borders = [(beside_m, reaches) for beside_m, reaches in borders if reaches.any() and not reaches[0]]
        if not borders:
            continue
        due_m = float(path.s[int(borders[0][1].argmax())] - path.s[0])
        # A later decision begins further out. An ego that has stopped so near that it may be in their path already
        # stays where it is. Otherwise it creeps on with every noisy measurement.
        stays = borders[0][0] < 0.0 and abs(view.ego.speed_mps) <= MOVING_MPS
        waits = giving_way if isinstance(giving_way, bool) else view.objects[int(i)].id in giving_way
        # An ego that waits for a vehicle with an uncertain position stays, too: its reject reasons come and go.
        stays |= waits and uncertainty_m > 0.0
        if due_m > _due_m(case) and not stays:
            continue
        for beside_m, reaches in borders:
            reject = _check_follower(case, int(i), reaches, edge + (-beside_m if on_left else beside_m), waits)
            if reject is not None:
                return [reject]
    return []


def _due_m(case: CheckContext) -> float:
    """Return the distance from which a stop beside the traffic must begin now (m): the next check is too late.

    Until the next check the ego speeds up and moves on, which counts for a vehicle that has just set off.
    """
    policy, limits = case.policy.entry, case.view.ego.limits
    soon_mps = case.view.ego.speed_mps + limits.comfort_acceleration_mps2 * policy.next_look_s
    stop_m = stopping_distance_m(soon_mps, limits.comfort_braking_mps2, policy.stops_s)
    return soon_mps * policy.next_look_s + stop_m + policy.stops_m


def _check_follower(case: CheckContext, i: int, reaches: Mask, border: float, giving_way: bool) -> RejectReason | None:
    """Check one vehicle from behind against the ego's body beyond a border of the vehicle's path.

    `reaches` (stations,) is True where the body is beyond the border, whose lateral offset is `border` (m).
    """
    k = int(reaches.argmax())
    tail = tail_inside_border_s(case, k, np.full(len(case.path.s) - k, border), bool(case.view.d[i] > case.path.d[0]))
    # A slow ego gives the vehicle time to come nearer; a fast ego is less likely to be passed by it.
    reaction_s = case.policy.rss.reaction_s if giving_way else case.policy.entry.watching_reaction_s
    rejects = (_could_not_stop(case, run, k, i, tail, reaction_s) for run in (case.slow, case.quick))
    return next((reject for reject in rejects if reject is not None), None)


def _could_not_stop(
    case: CheckContext, run: SpeedProfile, k: int, i: int, tail: Array, reaction_s: float
) -> RejectReason | None:
    """Check an object from behind if the ego enters its path at station `k`."""
    view, policy, obj = case.view, case.policy, case.view.objects[i]
    now, when, lane = float(view.vs[i]), float(run.t[k]), view.lane_of[i]
    limit = (lane.strip.speed_limit_mps if lane else None) or policy.oncoming.unknown_limit_mps
    gains = policy.entry.accelerates_mps2
    speed = max(now, min(now + gains * when, limit))
    gaining_s = (speed - now) / max(gains, EPSILON)
    front = float(view.s[i]) + (now + speed) / 2 * gaining_s + speed * (when - gaining_s) + float(view.along[i])
    if front - 2 * float(view.along[i]) > float(case.path.s[k]) + view.ego.length_m / 2:
        return None  # The vehicle has passed the ego before the entry.
    sooner = (policy.rss.reaction_s - reaction_s) * speed
    needs = [rss_distance(speed, float(v), policy.rss, running=True) for v in run.v[k : k + len(tail)]]
    needed = np.array(needs) - sooner
    if (tail - front >= needed).all():
        return None
    gap, required_m = float(tail.min()) - front, float(needed[int(np.argmin(tail - front - needed))])
    detail = f"{obj.kind.value} {obj.id} behind: gap {gap:.1f} m, required {required_m:.1f} m at {when:.1f} s"
    return _rejected(obj, detail, when, gap, gap - required_m)


def _rejected(obj: TrackedObject, detail: str, time_s: float, gap_m: float, margin_m: float) -> RejectReason:
    return RejectReason(
        code=RejectCode.LANE_ENTRY,
        detail=detail,
        object_id=obj.id,
        time_s=time_s,
        gap_m=gap_m,
        margin=margin_m,
        unit="m",
    )


def _tail(case: CheckContext, lane: Lane, k: int) -> Array:
    """(some stations,): arc length of the rearmost part of the body inside a lane (m), until the whole body is inside.

    The stations begin at the entry `k`. While the body turns in, its tail is still outside: traffic in the lane must
    stop for the part that is inside.
    """
    s = case.path.s[k:]
    from_right = bool(case.path.d[k] <= np.interp(s[0], lane.s, lane.center))
    return tail_inside_border_s(case, k, np.interp(s, lane.s, lane.right if from_right else lane.left), from_right)


def tail_inside_border_s(case: CheckContext, k: int, border: Array, from_right: bool) -> Array:
    """Return the same for a border with offsets (m) at the stations from `k` on, crossed from the right or left."""
    path, half_length, half_width = case.path, case.view.ego.length_m / 2, case.view.ego.width_m / 2
    s, d, turn = path.s[k:], path.d[k:], case.heading[k:]
    beyond = (border - d if from_right else d - border) - half_width * np.cos(turn)
    slope = np.maximum(np.sin(turn) if from_right else -np.sin(turn), EPSILON)
    along = np.clip(beyond / slope, -half_length, half_length)
    tail: Array = s + along * np.cos(turn) - half_width * np.abs(np.sin(turn))
    whole = np.flatnonzero(along <= -half_length)
    return tail[: int(whole[0]) + 1] if len(whole) else tail


def _follow_distance_m(case: CheckContext, own_mps: float, front_mps: float) -> float:
    """Return the distance to keep behind a vehicle that the ego joins (m): Lemma 2 with the ego's own reaction time."""
    policy = case.policy
    own = stopping_distance_m(own_mps, case.view.ego.limits.comfort_braking_mps2, policy.entry.own_reaction_s)
    return max(own - front_mps**2 / (2 * policy.rss.max_braking_mps2), 0.0)


def check_entry_gap(case: CheckContext, k: int, i: int, tail: Array) -> RejectReason | None:
    """Check the distance to an object if the ego enters at station `k`, for all speeds from the slow to the fast ego.

    Traffic from behind responds from the entry on, by Lemma 2. The point where it can stop does not depend on when it
    is computed. It must be behind every position of the ego's tail, plus the ego's own stopping distance from there.
    """
    view, policy, obj = case.view, case.policy, case.view.objects[i]
    half, speed = view.ego.length_m / 2, float(view.vs[i])
    sides = set()
    for run in (case.slow, case.quick):
        # Before the start the ego needs time to set off. While the plan runs, its speed is known.
        when = float(run.t[k]) + (0.0 if case.running or run is case.quick else policy.entry.start_s)
        center_s = float(view.s[i]) + speed * when
        ahead = center_s - float(view.along[i]) - (float(case.path.s[k]) + half)
        behind = tail - (center_s + float(view.along[i]))
        needs = (rss_distance(speed, float(v), policy.rss, running=case.running) for v in run.v[k : k + len(tail)])
        slack = [free - needed for free, needed in zip(behind, needs, strict=True)]
        worst = int(np.argmin(slack))
        if ahead > float(behind.min()):
            gap, relation, needed = ahead, "ahead", _follow_distance_m(case, float(run.v[k]), speed)
        else:
            gap, relation, needed = float(behind[worst]), "behind", float(behind[worst] - slack[worst])
        needed += 0.0 if case.running else policy.entry.reserve_m
        sides.add(relation)
        if gap < needed or len(sides) > 1:
            detail = f"{obj.kind.value} {obj.id} {relation}: gap {gap:.1f} m, required {needed:.1f} m at {when:.1f} s"
            if gap >= needed:
                detail = f"{obj.kind.value} {obj.id}: ahead of the slow ego and behind the fast one, or vice versa"
            return _rejected(obj, detail, when, gap, min(gap - needed, 0.0))
    return None
