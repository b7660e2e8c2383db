"""Checks whether the ego may turn around on the road: as a whole before it begins, then leg by leg from rest.

A leg is a path in the plane. At each of its poses the body is checked against all stationary objects. It is checked
against all moving ones for the duration of the leg, whether they follow their lane, go straight on, or brake. No
traffic on the road may reach the body before the turn is done. Traffic from occluded parts of the road must be able to
stop (Lemma 2 of RSS, as for a lane entry).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stucksolver.guard.policy import Approvals, GuardPolicy
from stucksolver.guard.rss import rss_distance, step_off
from stucksolver.guard.verdict import OK, RejectReason, Verdict, no_path
from stucksolver.plan.behaviors import AbortAction, ApprovalLevel, LegBehavior, NoPathError
from stucksolver.plan.multi_point_turn import POSE_STEP_M, Leg, corners, gaps_m, room_at_edges_m
from stucksolver.scene.boxes import separation
from stucksolver.scene.failed_attempts import PlanFailure, RejectCode
from stucksolver.scene.frenet import Array, Lane, Mask
from stucksolver.scene.frenet_scene import MOVING_MPS, FrenetScene
from stucksolver.scene.objects import ObjectKind
from stucksolver.scene.road import LaneDirection, LaneKind, LineKind

CLOSING = frozenset({ObjectKind.BARRIER, ObjectKind.CONE})
"""Kinds of objects that close a road: no traffic passes them."""


@dataclass(frozen=True)
class ProvenLeg:
    """Accepted leg of a turn.

    Attributes:
        behavior: Turn.
        leg: Leg.
        after_s: Duration of the legs after it, with the pauses between them (s).
        expected_s: Duration of this leg (s).
    """

    behavior: LegBehavior
    leg: Leg
    after_s: float
    expected_s: float

    @property
    def reverse(self) -> bool:
        """True if the leg backs up."""
        return self.leg.reverse

    def at(self, view: FrenetScene) -> int:
        """Return the index of the leg's pose nearest to the ego."""
        away = (self.leg.x_m - view.ego.x_m) ** 2 + (self.leg.y_m - view.ego.y_m) ** 2
        return int(away.argmin())

    def left_m(self, view: FrenetScene) -> float:
        """Return the remaining distance on the leg (m)."""
        return POSE_STEP_M * (len(self.leg.x_m) - 1 - self.at(view))

    def rest(self, view: FrenetScene) -> Leg:
        """Return the rest of the leg from the ego's position."""
        k = min(self.at(view), len(self.leg.x_m) - 2)
        return replace(self.leg, x_m=self.leg.x_m[k:], y_m=self.leg.y_m[k:], yaw_rad=self.leg.yaw_rad[k:])


def prove_turn(
    behavior: LegBehavior, view: FrenetScene, policy: GuardPolicy, approvals: Approvals
) -> tuple[Verdict, ProvenLeg | None]:
    """Check the whole rest of a turn from the ego's present pose. A turn without a path is rejected with `NO_PATH`.

    Returns:
        Verdict, and the first leg (None if rejected).
    """
    try:
        if abs(view.ego.speed_mps) > policy.stopping.rests_mps:
            raise NoPathError(PlanFailure.MUST_BE_STOPPED, "the vehicle must stop before turning around")
        legs = behavior.legs(view)
        if not legs:
            raise NoPathError(PlanFailure.PRECONDITION, "the vehicle already faces the other way")
    except NoPathError as error:
        return no_path(error), None
    took = [_duration_s(leg, view, behavior, policy) for leg in legs]
    after_s = sum(took[1:]) + policy.turning.shifts_s * (len(took) - 1)
    begun = bool(abs(view.ego_yaw) > policy.tracking.askew_rad)
    swept = _span(view, legs)
    rejects = _zones(view, swept, policy) + _solid_line(view, swept, policy, approvals)
    rejects += _edges(view, legs, policy) + _sight(view, swept, policy)
    # After the ego is across the road, all traffic can detect it and stop.
    approaching_s = took[0] + (0.0 if begun else after_s)
    rejects += _approaching_traffic(view, swept, approaching_s, policy)
    rejects += [reject for leg in legs for reject in _standing(view, leg, policy, behavior.speed_mps)][:1]
    rejects += _moving(view, legs[0], policy, behavior.speed_mps)
    if rejects:
        return Verdict(rejects=tuple(rejects)), None
    return OK, ProvenLeg(behavior, legs[0], after_s, took[0])


def unreleased_line(
    behavior: LegBehavior, at: tuple[float, float], view: FrenetScene, policy: GuardPolicy, approvals: Approvals
) -> Verdict:
    """Check in advance whether a later turn of a plan may cross the lines where it will begin.

    A person must be asked before the first step of the plan, not after it. All other checks of the turn depend on its
    start, so `prove_turn` makes them at that time.

    Args:
        behavior: Turn.
        at: (x, y) in the local frame of the body's center when the turn begins (m).
        view: Surroundings in road coordinates, from the present position of the ego.
        policy: Bounds of the guard.
        approvals: Approvals by people.

    Returns:
        Rejection with `SOLID_LINE` or `OFF_ROAD`; accepted if no line prevents the turn, or it has no path from there.
    """
    there = view.surroundings.ego.model_copy(update={"x_m": at[0], "y_m": at[1], "speed_mps": 0.0})
    later = FrenetScene(view.surroundings.model_copy(update={"ego": there}))
    try:
        legs = behavior.legs(later)
    except NoPathError:
        return OK
    return Verdict(rejects=tuple(_solid_line(later, _span(later, legs), policy, approvals))) if legs else OK


def recheck_leg(proven: ProvenLeg, view: FrenetScene, policy: GuardPolicy) -> Verdict:
    """Check a running leg on this tick. A rejection has the abort: a final stop, or yielding to traffic."""
    braking = view.ego.limits.comfort_braking_mps2
    k = proven.at(view)
    away = float(np.hypot(proven.leg.x_m[k] - view.ego.x_m, proven.leg.y_m[k] - view.ego.y_m))
    turn = float(np.cos(view.ego.yaw_rad - proven.leg.yaw_rad[k]))
    if away > policy.turning.error_m or turn < np.cos(policy.turning.error_rad):
        angle_rad, allowed = float(np.arccos(np.clip(turn, -1, 1))), policy.turning
        detail = (
            f"ego {away:.2f} m and {angle_rad:.2f} rad off the proven leg, allowed {allowed.error_m:.2f} m and "
            f"{allowed.error_rad:.2f} rad"
        )
        off = RejectReason(code=RejectCode.DEVIATION, detail=detail, gap_m=away)
        return Verdict(rejects=(off,), abort=AbortAction.STOP, brake_mps2=braking)
    rest, speed = proven.rest(view), proven.behavior.speed_mps
    rejects = _standing(view, rest, policy, speed, running=True) + _moving(view, rest, policy, speed, running=True)
    if not rejects:
        return OK
    return Verdict(rejects=tuple(rejects), abort=AbortAction.YIELD, brake_mps2=view.ego.limits.max_braking_mps2)


def _duration_s(leg: Leg, view: FrenetScene, behavior: LegBehavior, policy: GuardPolicy) -> float:
    speed = min(policy.turning.slowest_mps, behavior.speed_mps)
    sets_off = speed / (policy.prediction.sluggish_acceleration * view.ego.limits.comfort_acceleration_mps2)
    return leg.length_m / speed + sets_off


def _span(view: FrenetScene, legs: tuple[Leg, ...]) -> tuple[float, float]:
    """Return the lowest and the highest arc length that the body reaches in any leg (m)."""
    s = np.concatenate([corners(view, leg.x_m, leg.y_m, leg.yaw_rad)[0].ravel() for leg in legs])
    return float(s.min()), float(s.max())


def _zones(view: FrenetScene, swept: tuple[float, float], policy: GuardPolicy) -> list[RejectReason]:
    margin_m = policy.lanes.zone_margin_m
    for zone in view.surroundings.road.zones:
        if zone.start_m - margin_m < swept[1] and swept[0] < zone.end_m + margin_m:
            detail = f"turn within {margin_m:.1f} m of a {zone.kind.value.replace('_', ' ')}"
            return [RejectReason(code=RejectCode.ZONE, detail=detail)]
    return []


def _solid_line(
    view: FrenetScene, swept: tuple[float, float], policy: GuardPolicy, approvals: Approvals
) -> list[RejectReason]:
    """Check that no curb is crossed, and a solid line between lanes only as the policy allows."""
    lines = [
        lane.lines(max(swept[0], lane.start_m), min(swept[1], lane.end_m))
        for lane in view.frame.lanes
        if lane.strip.kind is LaneKind.DRIVING and lane.covers(view.ego_s, view.ego_s)
    ]
    if any(LineKind.KERB in kinds for kinds in lines):
        return [RejectReason(code=RejectCode.OFF_ROAD, detail="the path crosses a curb")]
    if not any(LineKind.SOLID in kinds for kinds in lines):
        return []
    if policy.solid_line == "forbid":
        return [RejectReason(code=RejectCode.SOLID_LINE, detail="solid line: crossing is forbidden here")]
    if not approvals.cover("solid_line", ApprovalLevel(policy.solid_line)):
        why = f"solid line: crossing requires approval from the {policy.solid_line}"
        return [RejectReason(code=RejectCode.SOLID_LINE, detail=why)]
    return []


def _edges(view: FrenetScene, legs: tuple[Leg, ...], policy: GuardPolicy) -> list[RejectReason]:
    distance_m = np.concatenate([room_at_edges_m(view, leg.x_m, leg.y_m, leg.yaw_rad) for leg in legs])
    least = min(policy.turning.edge_m, float(distance_m[0]) - policy.lanes.further_out_m)
    if float(distance_m.min()) >= least:
        return []
    detail = f"corner {distance_m.min():.2f} m from the edge of the road, required {least:.2f} m"
    return [RejectReason(code=RejectCode.OFF_LANES, detail=detail, gap_m=float(distance_m.min()))]


def _sight(view: FrenetScene, swept: tuple[float, float], policy: GuardPolicy) -> list[RejectReason]:
    """Check that the sight distance in each lane suffices for traffic at its speed limit to stop before the ego."""
    for lane in view.frame.lanes:
        if lane.strip.kind is not LaneKind.DRIVING or not lane.covers(view.ego_s, view.ego_s):
            continue
        ahead = lane.strip.direction is LaneDirection.OPPOSITE
        limit = lane.strip.speed_limit_mps or policy.oncoming.unknown_limit_mps
        stop_m = rss_distance(limit, 0.0, policy.rss, running=True)
        extent_m = swept[1] - view.ego_s if ahead else view.ego_s - swept[0]
        have = view.sight_ahead_m(lane) if ahead else view.sight_behind_m(lane)
        needed = extent_m + stop_m
        if have < needed and not _ends(view, lane, have if ahead else -have, policy):
            direction = "ahead" if ahead else "behind"
            detail = f"sight distance {direction} {have:.1f} m, required {needed:.1f} m to turn"
            return [RejectReason(code=RejectCode.PATH_NOT_VISIBLE, detail=detail, gap_m=have - needed)]
    return []


def _ends(view: FrenetScene, lane: Lane, sight_m: float, policy: GuardPolicy) -> bool:
    """True if a lane ends, or is closed, at the end of its sight. `sight_m`: from the ego (m), negative behind."""
    end_s = view.ego_s + sight_m
    sampled_m = policy.sight.sampled_m
    if end_s > lane.end_m - sampled_m or end_s < lane.start_m + sampled_m:
        return True
    right, _, left = lane.at(end_s)
    closing = np.array([o.kind in CLOSING for o in view.objects], dtype=bool)
    in_lane = (view.d + view.across > right + policy.sight.in_lane_m) & (view.d - view.across < left)
    return bool((closing & in_lane & (np.abs(view.s - end_s) < sampled_m + view.along)).any())


def _approaching_traffic(
    view: FrenetScene, swept: tuple[float, float], turn_s: float, policy: GuardPolicy
) -> list[RejectReason]:
    """Check that no traffic on the road, slightly faster than perceived, reaches the turn before it is done."""
    until_s, oncoming = turn_s + policy.oncoming.time_gap_s, policy.oncoming
    for i in np.flatnonzero(view.moving & view.on_lane & ~view.on_foot & (np.abs(view.vs) > MOVING_MPS)):
        ahead = bool(view.vs[i] > 0.0)
        near_m, far_m = (
            (swept[0] - view.s[i], view.s[i] - swept[1]) if ahead else (view.s[i] - swept[1], swept[0] - view.s[i])
        )
        gap_m, is_past = float(near_m - view.along[i]), bool(far_m > view.along[i])
        required_m = (abs(float(view.vs[i])) + oncoming.speedup_mps) * until_s
        if not is_past and gap_m < required_m:
            obj = view.objects[int(i)]
            detail = (
                f"{obj.kind.value} {obj.id} approaches: gap {gap_m:.0f} m, required {required_m:.0f} m "
                f"for a turn of {turn_s:.0f} s"
            )
            return [RejectReason(code=RejectCode.ONCOMING_GAP, detail=detail, object_id=obj.id, gap_m=gap_m)]
    return []


def _margins(view: FrenetScene, which: Array, policy: GuardPolicy, speed_mps: float, moving: bool) -> Array:
    """(objects,): gaps to keep (m)."""
    gaps = policy.clearance
    margin = np.full(len(which), gaps.moving_gap_m if moving else gaps.standing_gap_m)
    margin = np.where(view.vulnerable[which], np.maximum(margin, gaps.vulnerable_gap_m), margin)
    step_m = float(step_off(np.array([speed_mps]), view.ego.limits.max_braking_mps2, policy.people)[0])
    result: Array = np.where(view.on_foot[which], np.maximum(margin, step_m), margin)
    return result


def _standing(
    view: FrenetScene, leg: Leg, policy: GuardPolicy, speed_mps: float, running: bool = False
) -> list[RejectReason]:
    which = np.flatnonzero(view.speed <= MOVING_MPS)
    if not len(which):
        return []
    gap = gaps_m(view, which, leg.x_m, leg.y_m, leg.yaw_rad)
    margin = _margins(view, which, policy, speed_mps, moving=False)
    return _too_near(view, which, gap, margin - (policy.clearance.tracked_gap_m if running else 0.0), policy)


def _moving(
    view: FrenetScene, leg: Leg, policy: GuardPolicy, speed_mps: float, running: bool = False
) -> list[RejectReason]:
    """Check moving objects against every pose that the ego, slow or fast, may have at each instant."""
    which = np.flatnonzero(view.speed > MOVING_MPS)
    if not len(which):
        return []
    t, reached = _places(view, leg, policy, speed_mps)
    gap = np.full((len(leg.x_m), len(which)), np.inf)
    for x, y, yaw in _courses(view, which, t, policy):
        apart = separation(
            (leg.x_m[:, None, None], leg.y_m[:, None, None], leg.yaw_rad[:, None, None]),
            (view.ego.length_m / 2, view.ego.width_m / 2),
            (x, y, yaw),
            (view.half_length[which], view.half_width[which]),
        )
        gap = np.minimum(gap, np.where(reached[:, :, None], apart, np.inf).min(axis=1))
    margin = _margins(view, which, policy, speed_mps, moving=True)
    now = gaps_m(view, which, leg.x_m[:1], leg.y_m[:1], leg.yaw_rad[:1])
    gap = np.concatenate([now, gap])
    return _too_near(view, which, gap, margin - (policy.clearance.tracked_gap_m if running else 0.0), policy)


def _places(view: FrenetScene, leg: Leg, policy: GuardPolicy, speed_mps: float) -> tuple[Array, Mask]:
    """Return the instants until the leg ends (s from now), and (poses, instants): True if the ego may be there."""
    slow_mps = min(policy.turning.slowest_mps, speed_mps)
    gains = view.ego.limits.comfort_acceleration_mps2
    travel = POSE_STEP_M * np.arange(len(leg.x_m))
    slowly_s = slow_mps / (policy.prediction.sluggish_acceleration * gains)
    latest = travel / slow_mps + slowly_s
    earliest = travel / speed_mps
    t = np.arange(0.0, float(latest[-1]) + policy.prediction.step_s, policy.prediction.step_s)
    half_s = policy.prediction.step_s / 2
    reached: Mask = (t >= earliest[:, None] - half_s) & (t <= latest[:, None] + half_s)
    return t, reached


def _courses(view: FrenetScene, which: Array, t: Array, policy: GuardPolicy) -> list[tuple[Array, Array, Array]]:
    """Return x, y (m) and heading (rad), each (instants, objects), of three hypotheses.

    The object goes straight on, brakes straight on, or follows its lane.
    """
    objects = [view.objects[int(i)] for i in which]
    x, y, yaw, vx, vy = (
        np.array([getattr(o, n) for o in objects]) for n in ("x_m", "y_m", "yaw_rad", "vx_mps", "vy_mps")
    )
    speed = np.maximum(np.hypot(vx, vy), MOVING_MPS)
    until = np.minimum(t[:, None], speed / policy.prediction.braking_mps2)
    part = (speed * until - policy.prediction.braking_mps2 * until**2 / 2) / speed
    heading = np.broadcast_to(yaw, (len(t), len(which)))
    s, d = view.s[which] + view.vs[which] * t[:, None], np.broadcast_to(view.d[which], (len(t), len(which)))
    along_x, along_y, road = (a.reshape(s.shape) for a in view.frame.to_local(s.ravel(), d.ravel()))
    return [
        (x + vx * t[:, None], y + vy * t[:, None], heading),
        (x + vx * part, y + vy * part, heading),
        (along_x, along_y, road + view.yaw[which]),
    ]


def _too_near(view: FrenetScene, which: Array, gap: Array, margin: Array, policy: GuardPolicy) -> list[RejectReason]:
    """Return a reject reason for the nearest object with a gap (poses, objects) below its margin and its present value.

    The first row of `gap` is the present one.
    """
    bad = (gap < margin) & (gap < gap[0] - policy.clearance.nearer_m)
    if not bad.any():
        return []
    worst = np.where(bad, gap, np.inf).min(axis=0)
    k = int(worst.argmin())
    obj = view.objects[int(which[k])]
    code = RejectCode.COLLISION if worst[k] <= 0.0 else RejectCode.GAP
    if worst[k] > 0.0 and view.vulnerable[int(which[k])]:
        code = RejectCode.CLEARANCE
    detail = f"{obj.kind.value} {obj.id}: gap {worst[k]:.2f} m, required {margin[k]:.2f} m in the turn"
    return [RejectReason(code=code, detail=detail, object_id=obj.id, gap_m=float(worst[k]))]
