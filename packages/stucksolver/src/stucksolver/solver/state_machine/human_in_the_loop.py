"""Questions to people, their answers, and the stop in which help is called."""

from __future__ import annotations

import math
from dataclasses import replace

from stucksolver.guard import NOBODY
from stucksolver.ladder import CallAssistance, Resume
from stucksolver.plan import Directive, SafeStop
from stucksolver.reasoners import ReasonerAnswer
from stucksolver.scene import AttemptOutcome
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.events import EventKind
from stucksolver.solver.notices import IMMOVABLE
from stucksolver.solver.questions import Question, QuestionKind
from stucksolver.solver.state_machine.admission import Admission, with_approval
from stucksolver.solver.state_machine.history import signature
from stucksolver.solver.state_machine.pending_transition import PendingTransition
from stucksolver.solver.state_machine.state import AwaitingApproval, MinimalRisk, Monitoring

AHEAD_M = 25.0
"""Only a nearer object holds the vehicle (m): its driver would stop behind it, and not drive up to it first. Ours:
twice the stopping distance at 20 km/h, and a bus.
"""
CRAWLS_MPS = 0.5
"""A faster object moves on and blocks nothing (m/s): below the slowest walking pace."""


def blocked_at_m(view: FrenetScene) -> float | None:
    """Return the gap to the nearest object that stands in the route's path close ahead (m); None if there is none."""
    stands = view.in_corridor(view.ego.width_m / 2) & (view.s > view.ego_s) & (view.speed <= CRAWLS_MPS)
    nearest = float(view.gap[stands].min(initial=math.inf))
    return nearest if nearest < AHEAD_M else None


def blockage_text(turn: PendingTransition) -> str:
    """One line that says what blocks the way, and the binding constraint of the last plan.

    If nothing new has been seen for long, it says this, with the sensors' fault, instead of what was seen before.
    """
    scene, attempts, fault = turn.state.scene, turn.state.history.attempts, turn.state.senses_fault
    standstill, reason = turn.state.standstill, turn.state.history.reason
    parts = []
    ahead = scene.in_path_ahead(AHEAD_M) if scene else ()  # an object further away holds nobody up
    if turn.is_blind:
        parts.append(f"the sensors have shown nothing new for {turn.unseen_s:.0f} s" + (f" ({fault})" if fault else ""))
    elif standstill is not None and standstill.immovable:
        return IMMOVABLE.text
    elif ahead:
        nearest = ahead[0]
        parts.append(f"{nearest.kind.value} {nearest.id} blocks the way {max(nearest.gap_m or 0.0, 0.0):.0f} m ahead")
    if standstill is not None and standstill.reason is not None and standstill.reason.reject is not None:
        parts.append(f"the last plan failed: {standstill.reason.text}")
    elif attempts:
        parts.append(f"the last plan failed: {attempts[-1].outcome if reason is None else reason.text}")
    return "; ".join(parts) or "nothing helps, and nothing is seen in the way"


# ---- approval of a plan


def request_approval(turn: PendingTransition, judged: Admission, answer: ReasonerAnswer) -> None:
    """Ask a person to approve a plan that lacks only this approval."""
    need = judged.need
    assert need is not None
    turn.state = replace(turn.state, activity=AwaitingApproval(answer))
    what = " and ".join(name.replace("_", " ") for name in need.what)
    text = f"{answer.decision.rationale}. May I? It needs your yes for: {what}"
    within = turn.setup.ladder.asking.approval_within_s
    turn.ask_person(QuestionKind.APPROVAL, need.to, text, within_s=within, plan=judged.plan, needs=need.what)


def is_question_overdue(turn: PendingTransition) -> bool:
    """True if nobody answered the open question in time."""
    question = turn.state.question
    limit = None if question is None else question.within_s
    return limit is not None and turn.now_s - turn.state.question_since_s > limit


def handle_unanswered(turn: PendingTransition, question: Question) -> None:
    """Handle a question that nobody answered in time."""
    turn.withdraw_question()
    turn.tell(EventKind.CANCELLED, f"no answer from the {question.to}", question=question)
    if question.kind is QuestionKind.ADVICE:
        turn.climb()
    else:
        if question.plan is not None:
            told = f"no answer from the {question.to}"
            turn.state = replace(
                turn.state,
                history=turn.state.history.with_attempt(
                    question.plan, AttemptOutcome.REJECTED, turn.stack_s, text=told
                ),
            )
        turn.failed()


def record_approval(turn: PendingTransition, question: Question) -> None:
    """Keep an approval of this plan until the intervention ends."""
    under_way = turn.state.intervention
    assert question.plan is not None and under_way is not None
    key = signature(question.plan)
    yes = with_approval(under_way.approved.get(key, NOBODY), question.to, question.needs)
    turn.note(lambda under_way: replace(under_way, approved={**under_way.approved, key: yes}))


def record_declined_plan(turn: PendingTransition, question: Question) -> None:
    """Bar a plan that a person denied for the rest of this intervention."""
    assert question.plan is not None
    turn.state = replace(turn.state, activity=Monitoring())
    history = turn.state.history.denied(question.plan)
    turn.state = replace(turn.state, history=history.with_attempt(question.plan, AttemptOutcome.DECLINED, turn.stack_s))
    turn.failed()


# ---- help from outside


def stop_for_assistance(turn: PendingTransition, move: CallAssistance, gap_m: float) -> Directive:
    """Enter the minimal risk condition behind what blocks the path `gap_m` ahead (m), and call for help."""
    state = turn.state
    why = blockage_text(turn)
    assert not isinstance(state.posture, MinimalRisk)
    stop = MinimalRisk(SafeStop(reason=why), state.posture, turn.now_s, gap_m)
    turn.state = replace(turn.state, posture=stop)
    turn.tell(EventKind.STOPPED, f"minimal risk condition: {why}")
    call_for_help(turn, why)
    turn.pause(turn.now_s + move.look_every_s)
    return stop.directive


def not_held(turn: PendingTransition, move: CallAssistance, *, may_stop: bool) -> None:
    """Call for help and leave the vehicle to its driver: it may not stop here, or nothing is in its path."""
    why = blockage_text(turn)
    if turn.state.question is None:
        call_for_help(turn, why if may_stop else f"it stands where nobody should: {why}")
    turn.pause(turn.now_s + move.look_every_s)


def call_for_help(turn: PendingTransition, why: str) -> None:
    """Ask the operator for help and say why."""
    turn.ask_person(QuestionKind.ASSISTANCE, "operator", f"The vehicle needs help: {why}")


def still_calls(turn: PendingTransition) -> bool:
    """True if help stays called although the vehicle is its driver's again, because it has not set off yet."""
    question, under_way = turn.state.question, turn.state.intervention
    calls = question is not None and question.kind is QuestionKind.ASSISTANCE
    standstill = turn.state.standstill
    stands = (under_way is not None and under_way.stop_is_spent) or (standstill is not None and standstill.immovable)
    return calls and stands and abs(turn.status.speed_mps) < turn.setup.detector.v_min_mps


def resumes(turn: PendingTransition) -> Resume | None:
    """Return what ends the stop on the last rung, if anything does."""
    move = turn.state.escalation.move
    return move.resume if isinstance(move, CallAssistance) else None


def release(turn: PendingTransition, why: str, *, calls_on: bool = False) -> None:
    """End the stop. The rung stays until the hand-back is verified. `calls_on` keeps the call for help open."""
    posture, move = turn.state.posture, turn.state.escalation.move
    if isinstance(posture, MinimalRisk):
        turn.state = replace(turn.state, posture=posture.was)
    turn.note(lambda under_way: replace(under_way, tried_aside=False, handed_back=True, course=()))
    if not calls_on:
        turn.withdraw_question()
    turn.tell(EventKind.RELEASED, why)
    turn.state = replace(turn.state, detector_ignored_until_s=turn.now_s)  # it stood because it was told to stand
    turn.pause(turn.now_s + (move.look_every_s if isinstance(move, CallAssistance) else 0.0))


def helped_out(turn: PendingTransition, yes: bool) -> Directive:
    """Handle the operator's answer to the call for help."""
    if yes:
        release(turn, "the operator lets it try again")
        turn.note(lambda under_way: replace(under_way, stop_is_spent=False))
        turn.state = replace(turn.state, escalation=turn.state.escalation.reset())
    return turn.resting


def only_looks(turn: PendingTransition) -> bool:
    """True if the vehicle has stopped on the last rung and a plan of the reasoner does not count."""
    stopped = isinstance(turn.state.posture, MinimalRisk)
    return stopped and turn.state.words is None and resumes(turn) is not Resume.PLAN
