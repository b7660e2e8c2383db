"""Acts on the current rung of the ladder: asks reasoners and people, takes answers, and calls for help."""

from __future__ import annotations

import math
from dataclasses import replace

from stucksolver.guard import RejectCode, RejectReason, Verdict
from stucksolver.immobilization import Trigger
from stucksolver.ladder import AskPerson, AskReasoner, CallAssistance, Resume
from stucksolver.plan import CauseCode, Directive
from stucksolver.reasoners import ReasonerAnswer
from stucksolver.scene import AttemptOutcome
from stucksolver.solver.events import EventKind
from stucksolver.solver.notices import StandstillReason
from stucksolver.solver.query import NoAnswer, Query
from stucksolver.solver.questions import PersonReply, QuestionKind
from stucksolver.solver.state_machine import claims, hand_back, human_in_the_loop, plan_lifecycle, standoff
from stucksolver.solver.state_machine.history import GOT_ON_M, TEXTS
from stucksolver.solver.state_machine.human_in_the_loop import blockage_text
from stucksolver.solver.state_machine.pending_transition import PendingTransition
from stucksolver.solver.state_machine.perception_disagreement import find_disagreements, mask_disputed_scene
from stucksolver.solver.state_machine.state import (
    AwaitingApproval,
    AwaitingGap,
    Executing,
    MinimalRisk,
    Monitoring,
    Querying,
)


def next_step(turn: PendingTransition) -> Directive:
    """Ask whoever is next, because nothing is running."""
    now, question = turn.now_s, turn.state.question
    if question is not None and human_in_the_loop.is_question_overdue(turn):
        human_in_the_loop.handle_unanswered(turn, question)
    activity = turn.state.activity
    if isinstance(activity, AwaitingApproval):
        return turn.resting
    if isinstance(activity, AwaitingGap):
        return plan_lifecycle.await_gap(turn, activity)
    if turn.state.words is not None:
        climb = turn.state.guidance_escalation
        if climb.ready(now) and isinstance(climb.move, AskReasoner):
            _ask(turn, climb.move, Trigger.GUIDANCE)
        return turn.resting
    if turn.state.escalation.out_of_tries:
        turn.climb()
    if turn.state.escalation.ready(now):
        return _on_rung(turn)
    if now >= turn.state.escalation.not_before_s:
        _keep_calling(turn)  # even if the passenger asked to begin nothing
    return turn.resting


def _keep_calling(turn: PendingTransition) -> None:
    """Call again if the vehicle has stopped for good and no call is open.

    That happens after an operator's no, or when a question about words replaced the call.
    """
    posture, move = turn.state.posture, turn.state.escalation.move
    if isinstance(posture, MinimalRisk) and isinstance(move, CallAssistance) and turn.state.question is None:
        human_in_the_loop.call_for_help(turn, posture.stop.reason)
        turn.pause(turn.now_s + move.look_every_s)


def _on_rung(turn: PendingTransition) -> Directive:
    move, trigger = turn.state.escalation.move, turn.inputs.trigger
    if not isinstance(move, AskReasoner):
        turn.begin(trigger)
    posture = turn.state.posture
    if isinstance(move, CallAssistance) and not isinstance(posture, MinimalRisk):
        directive = _help(turn, move)
        if directive is not None:
            return directive
    if isinstance(move, AskPerson) and turn.state.question is None:
        escalation = turn.state.escalation
        since = turn.now_s if escalation.since_s == -math.inf else escalation.since_s
        turn.state = replace(turn.state, escalation=replace(escalation, since_s=since))
        left = since + move.within_s - turn.now_s
        if left <= 0.0:
            turn.climb()
            return turn.resting
        why = blockage_text(turn)
        turn.ask_person(QuestionKind.ADVICE, move.to, f"I cannot get on: {why}. What shall I do?", within_s=left)
    _keep_calling(turn)
    whom = move if isinstance(move, AskReasoner) else turn.state.escalation.lowest
    if whom is not None and human_in_the_loop.resumes(turn) is not Resume.OPERATOR:
        _ask(turn, whom, trigger or Trigger.SPEED)
    return turn.resting


def _help(turn: PendingTransition, move: CallAssistance) -> Directive | None:
    """The last rung: stop behind what blocks the path, at the best place in reach, and call for help.

    None if the vehicle is left to its driver: with nothing in its path, where the place does not allow a stop, and
    after a stop in the same intervention. Help is called all the same, and a way out is looked for repeatedly.
    """
    may_stop, under_way = plan_lifecycle.may_stop(turn), turn.state.intervention
    tried = under_way is not None and under_way.tried_aside
    gap_m = hand_back.blocked_at_m(turn)
    # A vehicle that moves with nothing in its path leaves a junction by itself.
    stands = gap_m is not None or abs(turn.status.speed_mps) <= turn.setup.guard.policy.stopping.rests_mps
    if (stands and not may_stop) or (gap_m is not None and move.pull_over and not tried):
        turn.note(lambda under_way: replace(under_way, tried_aside=True))
        judged = plan_lifecycle.aside(turn)
        if judged is not None and judged.verdict.accepted:
            return plan_lifecycle.start(turn, judged)
    if may_stop and gap_m is not None:
        return human_in_the_loop.stop_for_assistance(turn, move, gap_m)
    human_in_the_loop.not_held(turn, move, may_stop=may_stop)
    return None


# ---- reasoners


def _ask(turn: PendingTransition, move: AskReasoner, trigger: Trigger) -> None:
    """Start a question, unless the stack has no scene or the reasoner is still working on an older question."""
    turn.state = replace(turn.state, trigger=trigger)
    seen = turn.surroundings
    _look_back(turn)
    turn.tell(EventKind.TRIGGERED, trigger.value)
    shot = turn.inputs.scene()
    if shot.scene is None:
        _no_answer(turn, shot.why_none)
        return
    turn.state = replace(turn.state, camera_fault=shot.camera_fault)
    if move.reasoner in turn.inputs.busy:
        _no_answer(turn, f"{turn.setup.reasoners[move.reasoner]} is still busy with an older question")
        return
    if turn.state.intervention is None:
        gone_m = turn.setup.ladder.hand_back.gone_m
        turn.state = replace(turn.state, history=turn.state.history.about(shot.scene, turn.status.progress_m, gone_m))
    state, slow_since = turn.state, turn.inputs.slow_since_s
    ego = shot.scene.ego.model_copy(
        update={
            "yield_draw": standoff.draw(turn, shot.scene),
            "stopped_for_s": 0.0 if slow_since is None else round(turn.now_s - slow_since, 2),
            "progress_20s_m": turn.inputs.progress_in_window_m,
            "immobilized_below_mps": turn.setup.detector.v_min_mps,
            "expected_progress_m": turn.setup.detector.progress_m,
        }
    )
    words = None if state.words is None else state.words.words
    said = claims.active_claims(state, turn.now_s)
    told = {"ego": ego, "guidance": words, "claims": said, "attempts": state.history.attempts}
    query = Query(
        number=state.queries + 1,
        reasoner=move.reasoner,
        scene=mask_disputed_scene(shot.scene, state.doubts, turn.now_s).model_copy(update=told),
        asked_s=turn.now_s,
        deadline_s=move.deadline_s,
        screen=state.escalation.on.screens,
        outlived=state.escalation.expired_waits(turn.now_s),
        seen=seen,
        reading=state.reading,
        budget=move.budget,
    )
    turn.state = replace(turn.state, activity=Querying(query), queries=query.number, scene=query.scene)


def _look_back(turn: PendingTransition) -> None:
    """The vehicle is still immobilized after a finished plan: note whether that plan changed anything."""
    under_way = turn.state.intervention
    done = None if under_way is None else under_way.done
    turn.note(lambda under_way: replace(under_way, done=None))
    if done is None or turn.state.words is not None or turn.status.progress_m - done[1] >= GOT_ON_M:
        return
    plan, history, asked = done[0], turn.state.history, turn.state.scene
    yielded = asked is not None and asked.ego.yield_draw is not None  # who yields in a standoff makes no progress
    if yielded or not history.may_be_useless(plan):
        return
    turn.state = replace(
        turn.state, history=history.useless(plan).with_attempt(plan, AttemptOutcome.INEFFECTIVE, turn.stack_s)
    )
    turn.tell(EventKind.INEFFECTIVE, TEXTS[AttemptOutcome.INEFFECTIVE])


def take_answer(turn: PendingTransition) -> Directive:
    """Take the reasoner's answer, if there is one."""
    answer = turn.inputs.answer
    if answer is None:
        return turn.resting
    turn.state = replace(turn.state, activity=Monitoring())
    if isinstance(answer, NoAnswer):
        _no_answer(turn, answer.why, malformed=answer.malformed)
        return turn.resting
    if turn.state.scene is not None:
        turn.doubt(find_disagreements(turn.state.scene, answer.decision.observation))
    if answer.decision.plan is None or human_in_the_loop.only_looks(turn):
        _no_plan(turn, answer)
        return turn.resting
    directive = plan_lifecycle.judge(turn, answer, answer.decision.plan)
    return _asked_again(turn) if directive is None else directive


def _asked_again(turn: PendingTransition) -> Directive:
    """Ask again at once, with the reason for the refusal among the past attempts."""
    next_step(turn)
    return turn.resting


def _no_answer(turn: PendingTransition, why: str, *, malformed: bool = False) -> None:
    """There is no answer, or one that could not be used: it is refused like a plan with unsound numbers."""
    turn.begin(turn.state.trigger)
    verdict = Verdict(rejects=(RejectReason(code=RejectCode.IMPLAUSIBLE, detail=why),)) if malformed else None
    turn.tell(EventKind.FAILED, f"the reasoner gave no answer: {why}", verdict=verdict)
    standstill = turn.state.standstill
    if standstill is None or standstill.reason is None:
        turn.note_reason(StandstillReason(text=f"no way on is known: {why}", cause=CauseCode.UNKNOWN))
    turn.failed()


def _no_plan(turn: PendingTransition, answer: ReasonerAnswer) -> None:
    """The answer has no plan: either waiting is right, or the try led to nothing."""
    now = turn.now_s
    if turn.state.words is not None:
        turn.begin(turn.state.trigger)
        turn.tell_decision(answer, None)
        again = now + turn.setup.ladder.asking.recheck_s
        turn.state = replace(turn.state, guidance_escalation=turn.state.guidance_escalation.paused(again))
        return
    # A red light that was seen long ago is no reason to wait for ever.
    reason = None if turn.is_blind else answer.decision.analysis.wait
    waits = turn.state.escalation.note_wait(reason, now)
    if waits is None:
        turn.begin(turn.state.trigger)
    else:
        turn.state = replace(turn.state, escalation=waits)
    _note_reason(turn, answer, legitimate=waits is not None)
    turn.tell_decision(answer, None, waiting=waits is not None)
    if waits is None:
        turn.failed()
    else:
        standoff.back_off(turn, reason)


def _note_reason(turn: PendingTransition, answer: ReasonerAnswer, *, legitimate: bool) -> None:
    """Note why the vehicle stays: a legitimate wait, else the last verdict, which says more than "no safe way"."""
    analysis, standstill = answer.decision.analysis, turn.state.standstill
    if legitimate:
        turn.note_reason(StandstillReason(text=analysis.reason, wait=analysis.wait))
    elif standstill is not None and (standstill.reason is None or standstill.reason.reject is None):
        attempts, before = turn.state.history.attempts, turn.state.history.reason
        if before is not None and attempts and turn.stack_s - attempts[-1].time_s <= turn.now_s - standstill.since_s:
            turn.note_reason(before)
            return
        cause = analysis.cause or CauseCode.UNKNOWN
        turn.note_reason(StandstillReason(text=analysis.reason or answer.decision.rationale, cause=cause))


# ---- people


def handle_reply(turn: PendingTransition, reply: PersonReply) -> Directive:
    """Handle a person's yes or no."""
    question, activity = reply.question, turn.state.activity
    said = "yes" if reply.yes else "no"
    turn.tell(EventKind.ANSWERED, f"{reply.by}: {said}", question=question, answer=reply.yes)
    if question.kind is QuestionKind.ASSISTANCE:
        return human_in_the_loop.helped_out(turn, reply.yes)
    if not reply.yes or question.plan is None or not isinstance(activity, AwaitingApproval):
        human_in_the_loop.record_declined_plan(turn, question)
        return turn.resting
    human_in_the_loop.record_approval(turn, question)
    directive = plan_lifecycle.judge(turn, activity.answer, question.plan)
    return _asked_again(turn) if directive is None else directive


def close_questions(turn: PendingTransition) -> None:
    """The vehicle is moving on its own: nobody needs to answer any more."""
    if turn.drop_query():
        turn.tell(EventKind.CANCELLED, "the vehicle moves again")
    if not isinstance(turn.state.activity, Executing):
        turn.state = replace(turn.state, activity=Monitoring())
    turn.state = replace(turn.state, escalation=turn.state.escalation.note_motion())
    if human_in_the_loop.still_calls(turn):
        return
    question = turn.withdraw_question()
    if question is not None:
        turn.tell(EventKind.CANCELLED, "the vehicle moves again", question=question)
