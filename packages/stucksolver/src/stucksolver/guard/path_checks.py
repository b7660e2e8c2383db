"""Checks without a prediction of oncoming traffic. Each returns its reject reasons."""

from __future__ import annotations

import math

import numpy as np

from stucksolver.guard.adjacent_traffic import is_followed_lead
from stucksolver.guard.context import CheckContext
from stucksolver.guard.numerics import EPSILON, stopping_distance_m
from stucksolver.guard.policy import GuardPolicy
from stucksolver.guard.prediction import (
    gaps_at_heading,
    is_on_drift_side,
    moving_gaps,
    profiles,
    relevant,
    stationary_gaps,
    times,
)
from stucksolver.guard.rss import rss_lateral, step_off
from stucksolver.guard.speed_caps import check_speed_cap, drawn_to_doors, may_open
from stucksolver.guard.verdict import RejectReason
from stucksolver.plan.behaviors import ApprovalLevel
from stucksolver.plan.speed_profile import MIN_SPEED_MPS
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet import Array, Mask
from stucksolver.scene.frenet_scene import MOVING_MPS, FrenetScene
from stucksolver.scene.surroundings import ControlKind, LightState

NAMED = 3
"""Maximum number of objects in a verdict: the nearest ones."""


def collision(case: CheckContext) -> list[RejectReason]:
    """Check that no object is predicted to overlap the ego or to come nearer than its required gap.

    This includes doors that open and pedestrians who step off the curb.
    """
    which = relevant(case)
    if not len(which):
        return []
    view = case.view
    stands = view.speed[which] <= MOVING_MPS
    standing, moving = which[stands], which[~stands]
    rejects: list[RejectReason] = []
    if len(standing):
        gap = stationary_gaps(case, standing)
        rejects += _too_near(case, standing, gap, _margins(case, standing, case.quick.v), case.slow.t)
        rejects += _doors(case, standing, gap)
        if not case.running:
            rejects += _still_touched(case, standing, gap)
    if len(moving):
        t = times(case)
        stations = profiles(case, t)
        gap = moving_gaps(case, stations, moving, t)
        gap = np.where(is_followed_lead(case, stations, moving, t), np.maximum(gap, gap[:, :1]), gap)
        speed = np.maximum(np.interp(t, case.quick.t, case.quick.v), np.interp(t, case.slow.t, case.slow.v))
        rejects += _too_near(case, moving, gap.min(axis=0), _margins(case, moving, speed), t)
    return rejects


def least_stationary_gap(case: CheckContext) -> tuple[float | None, float | None]:
    """Return the smallest gap to stationary objects on the path, and its smallest excess over the required gap (m).

    The excess counts only where the ego comes nearer to an object than it is at the start. None without such an object.
    """
    which = relevant(case)
    standing = which[case.view.speed[which] <= MOVING_MPS] if len(which) else which
    if not len(standing):
        return None, None
    gap = stationary_gaps(case, standing)
    nearer = gap < gap[0] - case.policy.clearance.nearer_m
    excess = np.where(nearer, gap - _margins(case, standing, case.quick.v), np.inf)
    least = float(excess.min())
    return float(gap.min()), least if np.isfinite(least) else None


def _margins(case: CheckContext, which: Array, speed: Array) -> Array:
    """(instants, objects): gaps to keep (m) at the ego's `speed` (instants,) (m/s)."""
    view, policy = case.view, case.policy
    gaps, creep_mps = policy.clearance, policy.speeds.creep_mps
    drift = np.abs(view.vd[which])
    # Objects that move sideways faster, and those on other roads, are extrapolated sideways and need no margin.
    drift = np.where((drift > policy.prediction.crossing_mps) | view.elsewhere[which], 0.0, drift)
    # If both creep, the gap to stationary objects is enough, since the ego passes those even faster.
    crawls = view.speed[which] <= creep_mps
    creeping = (speed[:, None] <= creep_mps + EPSILON) & crawls
    mu = np.where(creeping, gaps.standing_gap_m, gaps.moving_gap_m)
    margin = np.where(view.moving[which], rss_lateral(drift, mu, policy.rss), gaps.standing_gap_m)
    margin = np.where(view.vulnerable[which], np.maximum(margin, gaps.vulnerable_gap_m), margin)
    margin = np.maximum(margin, _drawn_aside(case, speed)[:, None])
    stepping = view.on_foot[which]
    if not stepping.any():
        return margin
    step = step_off(speed, view.ego.limits.max_braking_mps2, policy.people)
    result: Array = np.maximum(margin, step[:, None] * stepping)
    return result


def _drawn_aside(case: CheckContext, speed: Array) -> Array:
    """(instants,): distance by which a tracking fault beside an object moves the body sideways until it stops (m)."""
    tracking, ego = case.policy.tracking, case.view.ego
    takes_s = case.policy.stopping.lag_s + speed / ego.limits.comfort_braking_mps2
    result: Array = tracking.beside_m + tracking.drift_mps * takes_s
    return result


def _too_near(case: CheckContext, which: Array, gap: Array, margin: Array, t: Array) -> list[RejectReason]:
    """Return a reject reason for each of the nearest objects with a gap (instants, objects) below its margin (m)."""
    # An object already nearer than its margin counts only if the plan brings it nearer still.
    gaps = case.policy.clearance
    required = margin - (gaps.tracked_gap_m if case.running else 0.0)
    bad = (gap < required) & (gap < gap[0] - gaps.nearer_m)
    drifted = is_on_drift_side(case, which)
    if drifted.any():
        bad[0] |= drifted & (
            (gap[0] < gaps.drifted_gap_m + _still_to_drift(case)) | _stops_against(case, which, gap[0])
        )
    if not bad.any():
        return []
    worst = np.where(bad, gap, np.inf).min(axis=0)
    nearest = [k for k in np.argsort(worst)[:NAMED] if np.isfinite(worst[k])]
    required = np.broadcast_to(required, gap.shape)
    at = np.where(bad, gap, np.inf).argmin(axis=0)
    return [
        _reject(case, int(which[k]), float(t[bad[:, k].argmax()]), float(worst[k]), float(required[at[k], k]))
        for k in nearest
    ]


def _still_touched(case: CheckContext, which: Array, gap: Array) -> list[RejectReason]:
    """Return a reject reason for each object in contact with the ego along which its path scrapes.

    The gap (stations, objects) (m) must open within `ClearancePolicy.parting_m` and stay open, at the latest at the end
    of the path. `_too_near` does not cover this, because the object never comes nearer.
    """
    touch_m = case.policy.harm.touch_m
    parted = np.hypot(case.path.s - case.path.s[0], case.path.d - case.path.d[0]) > case.policy.clearance.parting_m
    parted[-1] = True
    scraped = (gap[0] < touch_m) & (gap[parted] < touch_m).any(axis=0)
    rejects = []
    for k in np.flatnonzero(scraped)[:NAMED]:
        obj = case.view.objects[int(which[k])]
        gap_m = float(gap[:, k].min())
        detail = (
            f"{obj.kind.value} {obj.id}: scraped along, gap {gap_m:.2f} m, required {touch_m:.2f} m after "
            f"{case.policy.clearance.parting_m:.1f} m of the path"
        )
        rejects.append(
            RejectReason(
                code=RejectCode.COLLISION,
                detail=detail,
                object_id=obj.id,
                gap_m=gap_m,
                margin=gap_m - touch_m,
                unit="m",
            )
        )
    return rejects


def _still_to_drift(case: CheckContext) -> float:
    """Return how much further sideways the body moves while it stops at its present heading (m)."""
    if case.error_m * case.error_rad <= 0.0:
        return 0.0
    ego = case.view.ego
    way_m = stopping_distance_m(ego.speed_mps, ego.limits.comfort_braking_mps2, case.policy.stopping.lag_s)
    return float(np.sin(min(abs(case.error_rad), np.pi / 2)) * way_m)


def _stops_against(case: CheckContext, which: Array, gap: Array) -> Mask:
    """(objects,): True if a stop straight ahead at the present heading comes too near, and nearer than `gap` (m)."""
    ego = case.view.ego
    way_m = stopping_distance_m(ego.speed_mps, ego.limits.comfort_braking_mps2, case.policy.stopping.lag_s)
    left = gaps_at_heading(case, which, way_m).min(axis=0)
    gaps = case.policy.clearance
    result: Mask = ~case.view.moving[which] & (left < np.minimum(gaps.drifted_gap_m, gap - gaps.nearer_m))
    return result


def _doors(case: CheckContext, standing: Array, gap: Array) -> list[RejectReason]:
    """Check that the ego drives faster than walking pace only out of reach of the doors of parked vehicles.

    A tracking fault must not move the ego into their reach either, before it has slowed down to walking pace.
    """
    view, doors = case.view, case.policy.doors
    drift_m = drawn_to_doors(case, case.quick.v)
    near = standing[(gap < doors.reach_m + drift_m.max()).any(axis=0)]
    fast = case.quick.v > case.policy.speeds.creep_mps + EPSILON
    which = np.array([i for i in near if may_open(view.objects[int(i)], doors.parked_s)], dtype=int)
    if not len(which) or not fast.any():
        return []
    reach = stationary_gaps(case, which, aside_m=doors.reach_m, part=doors.part_of_length)
    bad = (reach < drift_m[:, None] - EPSILON) & (reach < reach[0] - case.policy.clearance.nearer_m) & fast[:, None]
    # Beside the door a fault that has begun continues, although the path keeps its distance.
    bad[0] |= is_on_drift_side(case, which) & (reach[0] < drift_m[0]) & fast[0]
    rejects = []
    for k in np.flatnonzero(bad.any(axis=0)):
        obj, first = view.objects[int(which[k])], int(bad[:, k].argmax())
        detail = (
            f"{obj.kind.value} {obj.id}: gap {reach[first, k]:.2f} m to an open door, "
            f"required {drift_m[first]:.2f} m above walking pace"
        )
        rejects.append(
            RejectReason(
                code=RejectCode.DOOR,
                detail=detail,
                object_id=obj.id,
                time_s=float(case.slow.t[first]),
                margin=float(reach[first, k] - drift_m[first]),
                unit="m",
            )
        )
    return rejects


def _reject(case: CheckContext, index: int, time_s: float, gap_m: float, required_m: float) -> RejectReason:
    obj = case.view.objects[index]
    code = RejectCode.COLLISION if gap_m <= 0 else RejectCode.GAP
    if gap_m > 0 and case.view.vulnerable[index]:
        code = RejectCode.CLEARANCE
    detail = f"{obj.kind.value} {obj.id}: gap {gap_m:.2f} m, required {required_m:.2f} m at {time_s:.1f} s"
    margin_m = gap_m - required_m
    if gap_m >= required_m:
        least_m = case.policy.clearance.drifted_gap_m
        margin_m = min(gap_m - least_m, 0.0)
        detail = f"{obj.kind.value} {obj.id}: gap {gap_m:.2f} m; tracking error leaves less than {least_m:.2f} m"
    return RejectReason(
        code=code, detail=detail, object_id=obj.id, time_s=time_s, gap_m=gap_m, margin=margin_m, unit="m"
    )


def drivable_area(case: CheckContext) -> list[RejectReason]:
    """Check that the body stays on the driving lanes."""
    return within(case, case.view.frame.drivable, RejectCode.OFF_LANES, "the driving lanes")


def roadside(case: CheckContext) -> list[RejectReason]:
    """Check that the body stays where a vehicle may stop: driving lanes, parking lanes and shoulders."""
    return within(case, case.view.frame.roadside, RejectCode.OFF_ROAD, "the road")


def within(case: CheckContext, borders: tuple[Array, Array], code: RejectCode, area: str) -> list[RejectReason]:
    """Check that the body stays between two borders.

    Args:
        case: Plan being checked.
        borders: Lateral offsets of the right and left border, each (stations of the frame,) (m).
        code: Code of the reject reason.
        area: Name of the area between the borders, for the text of the reject reason.
    """
    low, high = borders
    s = case.path.s
    stations = case.view.frame.s
    tolerance = case.policy.lanes.drivable_tolerance_m
    over_left = case.path.d + case.reach - np.interp(s, stations, high)
    over_right = np.interp(s, stations, low) - (case.path.d - case.reach)
    beyond = np.maximum(over_left, over_right)
    if case.path.end_s > case.view.frame.end_m:
        margin_m = case.view.frame.end_m - case.path.end_s
        return [
            RejectReason(
                code=RejectCode.OFF_ROAD, detail="the path runs beyond the known road", margin=margin_m, unit="m"
            )
        ]
    # An ego that already reaches over an edge may leave it, but must not go further out and must end on the road.
    allowed = np.full(len(s), max(tolerance, float(beyond[0]) + case.policy.lanes.further_out_m))
    allowed[-1] = tolerance
    worst = int((beyond - allowed).argmax())
    if beyond[worst] <= allowed[worst]:
        return []
    away_m = s[worst] - s[0]
    detail = f"{beyond[worst]:.2f} m off {area} {away_m:.0f} m ahead, allowed {allowed[worst]:.2f} m"
    margin_m = float(allowed[worst] - beyond[worst])
    return [RejectReason(code=code, detail=detail, gap_m=-float(beyond[worst]), margin=margin_m, unit="m")]


def speed(case: CheckContext) -> list[RejectReason]:
    """Check the limits of the lanes, the speed cap, and that the ego can slow down to the path's final speed.

    The cap is low in a recovery and higher for a pass or a passenger's request. Limits and people may change while the
    plan runs, the path does not. If it is too short to slow down, the ego drives beyond its end, where no check holds.
    """
    speeds, ends = case.policy.speeds, float(case.path.speed[-1])
    quicker = check_speed_cap(case)
    if quicker is not None or case.running:
        return [quicker] if quicker else []
    left = float(case.quick.v[-1])
    if left > max(ends, MIN_SPEED_MPS) + speeds.tolerance_mps:
        detail = f"speed {left:.1f} m/s at the end of the path, required {ends:.1f} m/s"
        return [RejectReason(code=RejectCode.OVERSPEED, detail=detail, margin=ends - left, unit="m/s")]
    return []


def stop_line(case: CheckContext) -> list[RejectReason]:
    """Check that a stop line is crossed only at a green light, or at a creep after a stop at a dark light or stop sign.

    Only an operator may approve crossing at a red light, and only if the whole path is at a creep. While a plan runs, a
    line is ignored if comfortable braking can no longer stop before it. The plan ends if a light goes dark or a stop
    sign becomes visible, because the plan did not begin from a stop there.
    """
    ego = case.view.ego
    reach = case.path.end_s + ego.length_m / 2 - case.view.ego_front_s
    nearest = ego.speed_mps**2 / (2 * ego.limits.comfort_braking_mps2) if case.running else 0.0
    for control in case.view.surroundings.controls:
        light = control.kind is ControlKind.TRAFFIC_LIGHT
        least = nearest - (case.policy.controls.over_line_m if light else 0.0)
        if control.applies is False or not least <= control.distance_m < reach:
            continue
        if light and control.state is LightState.GREEN:
            continue
        if light and control.state is not LightState.OFF:
            state = control.state.value if control.state else "unknown"
            if not (case.approvals.cover("red_light", ApprovalLevel.OPERATOR) and _creeps_over(case, math.inf)):
                return [
                    RejectReason(code=RejectCode.RED_LIGHT, detail=f"{state} light {control.distance_m:.0f} m ahead")
                ]
        elif (light or control.kind is ControlKind.STOP_SIGN) and not _was_stopped_at(case, control.distance_m):
            name = "dark light (an all-way stop)" if light else "stop sign"
            detail = f"{name} {control.distance_m:.0f} m ahead: stop at it first, then creep"
            return [RejectReason(code=RejectCode.STOP_LINE, detail=detail)]
    return []


def stopped_at(view: FrenetScene, policy: GuardPolicy) -> tuple[float, ...]:
    """Return the arc lengths of the lines of dark lights and stop signs at which the ego has stopped (m)."""
    if view.ego.speed_mps >= policy.stopping.rests_mps:
        return ()
    return tuple(
        view.ego_front_s + control.distance_m
        for control in view.surroundings.controls
        if control.distance_m < policy.controls.at_line_m
        and (control.kind is ControlKind.STOP_SIGN or control.state is LightState.OFF)
    )


def _was_stopped_at(case: CheckContext, distance_m: float) -> bool:
    """True if the ego has stopped at a line and may creep over it, now or when the running plan began."""
    policy = case.policy
    if case.running:
        line_s = case.view.ego_front_s + distance_m
        return any(abs(line_s - known_s) < policy.controls.same_line_m for known_s in case.stopped_at_s)
    stopped = case.view.ego.speed_mps < policy.stopping.rests_mps and distance_m < policy.controls.at_line_m
    return stopped and _creeps_over(case, distance_m)


def _creeps_over(case: CheckContext, distance_m: float) -> bool:
    """True if the path stays at walking pace until the front bumper is over a line `distance_m` ahead (m)."""
    before = case.path.s <= case.path.s[0] + max(distance_m, 0.0) + case.policy.controls.creeps_past_m
    return bool((case.path.speed[before] <= case.policy.speeds.creep_mps + EPSILON).all())
