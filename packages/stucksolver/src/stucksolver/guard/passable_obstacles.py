"""Checks which objects may be passed and when, and which may be driven over."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.verdict import RejectReason
from stucksolver.plan.behaviors import Check, names_with
from stucksolver.scene.boxes import separation
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet_scene import MOVING_MPS
from stucksolver.scene.objects import PASSABLE_KINDS, VEHICLES, VULNERABLE, ObjectKind
from stucksolver.scene.road import LaneKind
from stucksolver.scene.surroundings import ControlKind, LightState
from stucksolver.scene.wording import stood_too_briefly


def check_wait_elapsed(case: CheckContext) -> list[RejectReason]:
    """Check that no queue is passed, and no vehicle that may only be waiting before it has been stationary long enough.

    A passenger may request to pass a moving vehicle, or not to wait. But no guidance allows passing a queue, or passing
    an emergency vehicle before the long wait.
    """
    view = case.view
    rejects = []
    for name in case.path.passes:
        i = view.index_of(name)
        if i is None or not may_be_vehicle(case, i):
            continue
        why = _moving(case, i) if view.speed[i] > MOVING_MPS else _standing(case, i)
        if why is not None:
            detail = f"{view.objects[i].kind.value} {name} {why}"
            rejects.append(RejectReason(code=RejectCode.WAIT_FIRST, detail=detail, object_id=name))
    return rejects


def may_be_vehicle(case: CheckContext, i: int) -> bool:
    """True for a vehicle of any kind, and for an object of unknown kind that is as long as one."""
    obj = case.view.objects[i]
    long = max(obj.length_m, obj.width_m) >= case.policy.queues.unknown_m
    return obj.kind in VEHICLES or (obj.kind is ObjectKind.UNKNOWN and long)


def _moving(case: CheckContext, i: int) -> str | None:
    if case.view.vs[i] < case.policy.prediction.along_mps:
        warns = case.view.objects[i].hazard_lights
        return "may be in a queue" if not warns and _waits_for_something(case, i) else None
    return None if case.guided or case.running else "is moving: follow it, do not pass it"


def _standing(case: CheckContext, i: int) -> str | None:
    waits, obj = case.policy.waits, case.view.objects[i]
    if not obj.hazard_lights and is_queued(case, i):
        return "may be in a queue"
    stood = obj.stationary_s or 0.0
    if case.running or obj.kind is ObjectKind.UNKNOWN:
        return None
    if obj.kind is ObjectKind.EMERGENCY:
        # Its crew may return and drive off at any time, regardless of its lights and of any claim.
        return None if stood >= waits.unknown_vehicle_s else stood_too_briefly(stood, waits.unknown_vehicle_s)
    # A confirmed claim that the vehicle will stay counts as much as hazard lights.
    stays = "long_stay" in case.approvals.passenger | case.approvals.operator
    short = obj.hazard_lights or _parked(case, i) or stays
    needed = waits.hazard_or_parked_s if short else waits.unknown_vehicle_s
    return None if case.guided or stood >= needed else stood_too_briefly(stood, needed)


def _parked(case: CheckContext, i: int) -> bool:
    """True if the vehicle is where vehicles park: off the lane's center; for a two-wheeler outside driving lanes."""
    if case.view.two_wheeled[i]:
        lane = case.view.lane_of[i]
        return lane is None or lane.strip.kind is not LaneKind.DRIVING
    return abs(float(case.view.d[i])) > case.policy.queues.parked_offset_m


def is_queued(case: CheckContext, i: int) -> bool:
    """True if the vehicle seems to be waiting for another object ahead, judged by the present scene.

    It has moved recently, or a light, a stop sign or another vehicle, of any kind or unknown, is close ahead. That
    vehicle must itself have moved recently, or be stopped in the lane without hazard or emergency lights. The time for
    which a vehicle has been stationary does not distinguish a queue from an obstruction: it may have stopped long
    before the ego arrived.
    """
    return _moved_lately(case, i) or _waits_for_something(case, i)


def _waits_for_something(case: CheckContext, i: int) -> bool:
    """True if a light, a stop sign or another vehicle that may wait is close ahead of a vehicle."""
    view, policy = case.view, case.policy.queues
    front = float(view.gap[i] + 2 * view.along[i])
    for control in view.surroundings.controls:
        holds = control.kind is ControlKind.STOP_SIGN or control.state in (LightState.RED, LightState.YELLOW)
        near = front - policy.past_line_m <= control.distance_m < front + policy.reach_m
        if control.applies is not False and holds and near:
            return True
    in_line = np.abs(view.d - view.d[i]) < policy.in_line_m
    next_up = (view.gap > front) & (view.gap < front + policy.reach_m) & in_line
    ahead = [int(j) for j in np.flatnonzero(next_up) if may_be_vehicle(case, int(j))]
    return any(_moved_lately(case, j) or (_may_wait(case, i) and _may_wait(case, j)) for j in ahead)


def _moved_lately(case: CheckContext, i: int) -> bool:
    moved = case.view.objects[i].moved_s_ago
    return moved is not None and moved < case.policy.waits.queue_moved_within_s


def _may_wait(case: CheckContext, i: int) -> bool:
    """True if the object may be a waiting vehicle: in its lane, without hazard or emergency lights."""
    obj = case.view.objects[i]
    warns = obj.hazard_lights or obj.emergency_lights
    return not warns and not _parked(case, i) and may_be_vehicle(case, i)


def passable(case: CheckContext) -> list[RejectReason]:
    """Check that an object to drive over is soft, small, low, tracked long enough, and far from living beings."""
    rejects = []
    for name in case.path.over:
        i = case.view.index_of(name)
        why = "is no longer detected" if i is None else _not_passable(case, i)
        if why is not None:
            rejects.append(RejectReason(code=RejectCode.NOT_PASSABLE, detail=f"{name} {why}", object_id=name))
    return rejects


def _not_passable(case: CheckContext, i: int) -> str | None:
    obj, policy = case.view.objects[i], case.policy.passable
    driving_over = names_with(Check.PASSABLE)
    if not driving_over.isdisjoint(case.approvals.barred):
        return "must not be driven over: a person warned against it"
    if obj.kind not in PASSABLE_KINDS:
        return f"is classified as {obj.kind.value}, which is never driven over"
    confirmed = not {*driving_over, "soft_object"}.isdisjoint(case.approvals.passenger | case.approvals.operator)
    needed = policy.confirmed_confidence if confirmed else policy.confidence
    if (obj.kind_confidence or 0.0) < needed:
        sure = obj.kind_confidence or 0.0
        return f"is classified as {obj.kind.value} with confidence {sure:.2f}, required {needed:.2f}"
    if np.hypot(case.view.vs[i], case.view.vd[i]) > MOVING_MPS:
        return "is moving"
    longest = max(obj.length_m, obj.width_m)
    if longest > policy.size_m:
        return f"is {longest:.1f} m long, allowed {policy.size_m:.1f} m"
    if obj.height_m > policy.height_m:
        return f"is {obj.height_m:.2f} m high, allowed {policy.height_m:.2f} m"
    if (obj.seen_for_s or 0.0) < policy.seen_s:
        return f"has been tracked for {obj.seen_for_s or 0.0:.1f} s, required {policy.seen_s:.1f} s"
    return _living_near(case, i)


def _living_near(case: CheckContext, i: int) -> str | None:
    view = case.view
    for j, other in enumerate(view.objects):
        if j == i or other.kind not in VULNERABLE | {ObjectKind.UNKNOWN}:
            continue
        gap = separation(
            (view.s[i], view.d[i], view.yaw[i]),
            (view.half_length[i], view.half_width[i]),
            (view.s[j], view.d[j], view.yaw[j]),
            (view.half_length[j], view.half_width[j]),
        )
        least_m = case.policy.passable.living_clearance_m
        if float(gap) < least_m:
            return f"has {other.kind.value} {other.id} at {max(float(gap), 0.0):.1f} m, required {least_m:.1f} m"
    return None
