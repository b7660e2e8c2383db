"""Follows a standstill, and informs the passenger and the operator of its reason.

A notice is no question: nobody has to act on it, and it does not change the place on the ladder.
"""

from __future__ import annotations

from dataclasses import replace

from stucksolver.ladder.rung_actions import Person
from stucksolver.plan import WaitReason
from stucksolver.scene import ControlKind, LightState, Scene
from stucksolver.solver.events import EventKind
from stucksolver.solver.notices import IMMOVABLE, NOT_KNOWN, Notice, StandstillReason, verdict_reason
from stucksolver.solver.state_machine.pending_transition import PendingTransition
from stucksolver.solver.state_machine.state import Executing, MinimalRisk, Standstill

STANDS_MPS = 0.5
"""A slower vehicle begins a standstill (m/s). Ours: below the slowest walking pace."""
MOVED_ON_M = 2.0
"""New progress that ends a standstill, once the vehicle is faster than that (m). Ours: less than a queue moves up."""
LIGHT_M = 60.0
"""Within this distance a red light explains a wait in a queue (m). Ours: eight vehicles."""
PEOPLE: tuple[Person, ...] = ("passenger", "operator")


def follow(turn: PendingTransition) -> None:
    """Begin, continue or end the standstill. New progress ends it; driving back and forth does not."""
    standstill, status = turn.state.standstill, turn.status
    moves = status.speed_mps >= STANDS_MPS
    ended = standstill is not None and moves and status.progress_m - standstill.from_m >= MOVED_ON_M
    if standstill is not None and (ended or status.at_destination):
        turn.state = replace(turn.state, standstill=None)
        for notice, _ in standstill.told:
            turn.tell(EventKind.WAITING_ENDED, "the vehicle moves on", notice=notice)
    if turn.state.standstill is None and not moves and not status.at_destination:
        slow_s, dwell_s = turn.inputs.slow_since_s, turn.setup.detector.dwell_s
        since_s = turn.now_s if slow_s is None else max(slow_s, turn.now_s - dwell_s)
        turn.state = replace(turn.state, standstill=Standstill(since_s, status.progress_m))


def inform(turn: PendingTransition) -> None:
    """Inform each person who is due, once for each reason."""
    state, settings = turn.state, turn.setup.ladder.tell
    if state.standstill is None or turn.setup.observe_only or not _is_waiting(turn):
        return
    reason = _present_reason(turn)
    if reason is None:
        return
    for to, after_s in zip(PEOPLE, (settings.passenger_s, settings.operator_s), strict=True):
        if _is_due(turn, to, after_s, reason):
            _tell(turn, to, reason)


def _is_waiting(turn: PendingTransition) -> bool:
    """True if the vehicle stands, and not because people on board want it."""
    state = turn.state
    asked_to_wait = state.escalation.quiet_until_s > turn.now_s or state.letting_out
    return turn.status.speed_mps < STANDS_MPS and not asked_to_wait and not isinstance(state.posture, MinimalRisk)


def _present_reason(turn: PendingTransition) -> StandstillReason | None:
    """Return why the vehicle stands now; None while a plan is about to move it."""
    standstill, activity = turn.state.standstill, turn.state.activity
    assert standstill is not None
    if standstill.immovable:
        return IMMOVABLE
    if isinstance(activity, Executing):
        if not activity.execution.is_waiting:
            return None
        verdict = activity.execution.last_verdict
        found = None if verdict.accepted else verdict_reason(verdict, turn.view)
        return found or standstill.reason or NOT_KNOWN
    return standstill.reason or NOT_KNOWN


def _is_due(turn: PendingTransition, to: Person, after_s: float, reason: StandstillReason) -> bool:
    standstill, question = turn.state.standstill, turn.state.question
    assert standstill is not None
    if question is not None and question.to == to:
        return False  # the question itself says why
    if _is_for_light(reason, turn.state.scene):
        after_s = max(after_s, turn.setup.ladder.tell.light_s)
    told = next(((notice, when) for notice, when in standstill.told if notice.to == to), None)
    if told is None:
        return reason.immovable or turn.now_s - standstill.since_s >= after_s - 1e-6
    notice, when = told
    if notice.reason.key == reason.key:
        return False
    return reason.immovable or notice.reason == NOT_KNOWN or turn.now_s - when >= after_s


def _is_for_light(reason: StandstillReason, scene: Scene | None) -> bool:
    """True for a wait at a red light, or in a queue before one. A closed gate is not a light."""
    if reason.wait not in (WaitReason.LIGHT, WaitReason.QUEUE):
        return False
    lit = (LightState.RED, LightState.YELLOW)
    return scene is not None and any(
        c.kind is ControlKind.TRAFFIC_LIGHT
        and c.state in lit
        and c.applies is not False
        and -1.0 < c.distance_m < LIGHT_M
        for c in scene.controls
    )


def _tell(turn: PendingTransition, to: Person, reason: StandstillReason) -> None:
    standstill, number = turn.state.standstill, turn.state.notices + 1
    assert standstill is not None
    notice = Notice(id=f"n{number}", time_s=turn.stack_s, to=to, reason=reason)
    others = tuple(item for item in standstill.told if item[0].to != to)
    changed = replace(standstill, told=(*others, (notice, turn.now_s)))
    turn.state = replace(turn.state, standstill=changed, notices=number)
    turn.tell(EventKind.WAITING, reason.text, notice=notice)
