"""The hand-back: when a stop or a hold ends, and the watch over the stack's driver afterwards.

The vehicle is never held for good where its driver alone would go on: each hold and each stop has a limit. After it the
driver drives, and the guard brakes for it only at the last moment before it would touch something.
"""

from __future__ import annotations

import math
from dataclasses import replace

from stucksolver.ladder import Resume
from stucksolver.plan import CONTINUE, Directive
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.events import EventKind
from stucksolver.solver.notices import StandstillReason
from stucksolver.solver.state_machine import human_in_the_loop
from stucksolver.solver.state_machine.execution_steps import stand
from stucksolver.solver.state_machine.pending_transition import BLIND_LIMIT_S, PendingTransition
from stucksolver.solver.state_machine.state import Driving, Executing, Holding, MinimalRisk

HOLD_S = 60.0
"""A vehicle is held or stopped for at most this long at a time (s). Ours: two answers of a person. After each time that
the guard had to brake for the driver, the next hold may last twice as long, ...
"""
LONGEST_HOLD_S = 240.0
"""... but no longer than this (s). Ours: longer than a light or a train, shorter than a person takes to come."""
SETTLES_S = 3.0
"""Shortest hold after the guard had to brake for the driver (s): it stands by then, and has been asked again."""
FREE_S = 1.0
"""The reason of a stop must be gone for this long (s): an object that perception loses for a moment is not gone."""
MOVED_M = 2.0
"""What blocked the path has moved on if it is further away than at the stop by this much (m). Ours: more than sensors
err, less than a vehicle in a queue moves up.
"""
COURSE_S = 0.3
"""The curve that the driver drives is measured over this time (s): a few ticks."""
COURSE_M = 0.1
"""Over a shorter way the heading says nothing about the curve (m)."""


def blocked_at_m(turn: PendingTransition) -> float | None:
    """Return the gap to what stands in the path close ahead (m); None if nothing does, nothing is known, or the stop of
    this intervention is over.
    """
    under_way = turn.state.intervention
    if turn.view is None or turn.is_blind or (under_way is not None and under_way.stop_is_spent):
        return None
    return human_in_the_loop.blocked_at_m(turn.view)


# ---- a plan has ended


def after_plan(turn: PendingTransition) -> bool:
    """Hand the vehicle back after a plan, or hold it where the driver's own next second is not clear.

    Returns:
        True if it is held.
    """
    stays = not _clear(turn)
    hard = turn.view is not None and abs(turn.view.ego.speed_mps) > turn.setup.guard.policy.stopping.rests_mps
    brake = turn.view.ego.limits.max_braking_mps2 if hard and turn.view is not None else None
    turn.state = replace(turn.state, posture=Holding(turn.now_s, brake) if stays else Driving())
    turn.note(lambda under_way: replace(under_way, handed_back=True, course=()))
    return stays


def stay(turn: PendingTransition) -> Directive:
    """Hold the vehicle until the driver's own next second is clear, the hold is at its limit, or a plan begins."""
    posture, under_way = turn.state.posture, turn.state.intervention
    assert isinstance(posture, Holding)
    held_s, times = turn.now_s - posture.since_s, 0 if under_way is None else under_way.near_contacts
    limit_s = min(HOLD_S * 2.0 ** max(times - 1, 0), LONGEST_HOLD_S)
    settles = posture.brake_mps2 is not None and held_s < SETTLES_S
    if turn.status.at_destination or (not settles and _clear(turn)):
        return _let_go(turn, "the driver's own next second is clear")
    if held_s >= limit_s:
        return _let_go(turn, f"held for {limit_s:g} s: the driver drives, and is stopped before it touches anything")
    return stand(posture.brake_mps2)


def _let_go(turn: PendingTransition, why: str) -> Directive:
    turn.state = replace(turn.state, posture=Driving())
    turn.note(lambda under_way: replace(under_way, handed_back=True, course=()))
    turn.tell(EventKind.RELEASED, why)
    return CONTINUE


def _clear(turn: PendingTransition) -> bool:
    """True if the driver may go on from here, or if nothing has been seen for long."""
    if turn.view is None:
        return turn.sight.blind_s > BLIND_LIMIT_S
    return turn.is_blind or turn.setup.guard.clear_to_hand_back(turn.view)


# ---- the driver drives again


def watch(turn: PendingTransition) -> Directive:
    """After a hand-back, hold the vehicle at the last moment before its driver touches something."""
    under_way = turn.state.intervention
    if under_way is None or not under_way.handed_back or isinstance(turn.state.activity, Executing):
        return CONTINUE
    view = turn.view
    if view is None:
        return CONTINUE
    course = _course(under_way.course, view, turn.now_s)
    turn.note(lambda under_way: replace(under_way, course=course))
    touched = turn.setup.guard.about_to_touch(view, _curvature_per_m(course, view))
    if touched is None:
        return CONTINUE
    brake = view.ego.limits.max_braking_mps2
    turn.state = replace(turn.state, posture=Holding(turn.now_s, brake))
    turn.note(lambda under_way: replace(under_way, near_contacts=under_way.near_contacts + 1, course=()))
    turn.tell(EventKind.HELD, touched.detail)
    turn.note_reason(StandstillReason(text=touched.detail, reject=touched))
    return stand(brake)


def _course(
    before: tuple[tuple[float, float, float, float], ...], view: FrenetScene, now_s: float
) -> tuple[tuple[float, float, float, float], ...]:
    """Return the last poses with this tick's, without those that are too old; the oldest kept covers `COURSE_S`."""
    ego = view.ego
    poses = (*before, (now_s, ego.x_m, ego.y_m, ego.yaw_rad))
    late = [k for k, pose in enumerate(poses) if now_s - pose[0] >= COURSE_S]
    return poses[late[-1] if late else 0 :]


def _curvature_per_m(course: tuple[tuple[float, float, float, float], ...], view: FrenetScene) -> float:
    """Return the curvature of the driven path (1/m, left positive), within the vehicle's turning radius."""
    (_, x, y, yaw), ego = course[0], view.ego
    way = math.hypot(ego.x_m - x, ego.y_m - y) * (1.0 if ego.speed_mps >= 0.0 else -1.0)
    if abs(way) < COURSE_M:
        return 0.0
    tightest = 1.0 / ego.limits.min_turn_radius_m
    turned = math.remainder(ego.yaw_rad - yaw, math.tau)
    return max(-tightest, min(turned / way, tightest))


# ---- the stop of the last rung


def end_stop(turn: PendingTransition) -> None:
    """End the stop of the last rung if its reason has ended, or if it has lasted to its limit.

    Its reason has ended if what blocked the path is gone or has moved on, the driver's own next second is clear, and
    both have been seen for `FREE_S`. A stop that only the operator ends is left alone.
    """
    posture = turn.state.posture
    if not isinstance(posture, MinimalRisk) or human_in_the_loop.resumes(turn) not in (Resume.CLEAR, Resume.PLAN):
        return
    view, policy = turn.view, turn.setup.guard.policy
    known = view is not None and turn.unseen_s <= policy.max_age_s
    gap_m = human_in_the_loop.blocked_at_m(view) if view is not None and known else posture.gap_m
    moved_on = gap_m is None or gap_m > posture.gap_m + MOVED_M
    free = known and moved_on and _clear(turn)
    since = None if not free else turn.now_s if posture.free_since_s is None else posture.free_since_s
    nearest = posture.gap_m if gap_m is None else min(posture.gap_m, gap_m)
    if since is not None and turn.now_s - since >= FREE_S:
        _end(turn, "the way is free", calls_on=False)
    elif turn.now_s - posture.since_s >= HOLD_S:
        _end(turn, f"stopped for {HOLD_S:g} s: the driver drives, and help stays called", calls_on=True)
    else:
        turn.state = replace(turn.state, posture=replace(posture, gap_m=nearest, free_since_s=since))


def _end(turn: PendingTransition, why: str, *, calls_on: bool) -> None:
    turn.drop_query()
    human_in_the_loop.release(turn, why, calls_on=calls_on)
    turn.state = replace(turn.state, posture=Driving())
    turn.note(lambda under_way: replace(under_way, stop_is_spent=True))
