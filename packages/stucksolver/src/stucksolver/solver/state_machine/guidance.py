"""The passenger's words: which ones count, what they stop, and when they expire."""

from __future__ import annotations

import math
from dataclasses import replace

from stucksolver.ladder import Resume
from stucksolver.plan import GuidanceIntent
from stucksolver.scene import REQUESTS, Claim, Guidance, Interpretation
from stucksolver.scene.interpretation import MOVES, STAYS
from stucksolver.solver.events import EventKind
from stucksolver.solver.questions import PersonReply, Question, QuestionKind
from stucksolver.solver.state_machine import claims
from stucksolver.solver.state_machine.human_in_the_loop import resumes
from stucksolver.solver.state_machine.pending_transition import PendingTransition
from stucksolver.solver.state_machine.state import (
    ActiveGuidance,
    AwaitingGap,
    Executing,
    MinimalRisk,
    Monitoring,
    State,
)
from stucksolver.word_safeguards.restraint import STOPPING

LEAST_WAIT_S = 5.0
"""Whoever asks to wait gets at least this long (s): "three seconds" is seldom meant so."""
STOP_WINS_S = 2.0
"""What would move the vehicle and is said before a call to stop, or this long after it (s), does not count: about the
time for which two people who contradict each other talk at once. Ours.
"""


def answerable_question(state: State) -> Question | None:
    """Return the open question that the passenger's yes or no answers. "What shall I do?" is answered by a request."""
    asked = state.question
    answerable = asked is not None and asked.to == "passenger" and asked.kind is not QuestionKind.ADVICE
    return asked if answerable else None


def receive_guidance(turn: PendingTransition) -> None:
    """Act on words that were read, and drop words that have expired."""
    heard = turn.inputs.heard
    if heard is not None:
        turn.tell_fault(heard.fault)
        _understand(turn, heard.words)
    _overrule_yes(turn)
    if _expired(turn):
        turn.drop_query()
        attempts = turn.state.history.attempts
        end_words(turn, f"expired ({attempts[-1].outcome if attempts else 'no occasion'})")


def end_words(turn: PendingTransition, how: str) -> None:
    """Stop following the words."""
    in_force = turn.state.words
    assert in_force is not None
    _dismiss(turn, in_force.words, how)
    turn.state = replace(turn.state, words=None, history=turn.state.history.without_attempts())


def _expired(turn: PendingTransition) -> bool:
    """True if the words have led to nothing in time. Words that a running plan follows do not expire."""
    in_force, activity = turn.state.words, turn.state.activity
    if in_force is None or (isinstance(activity, Executing) and activity.words is in_force.words):
        return False
    return turn.now_s - in_force.since_s > turn.setup.ladder.words.expire_s


def _understand(turn: PendingTransition, words: Guidance) -> None:
    """Act on a reading: an answer, a refusal, a call to stop, a request, or nothing about the driving."""
    reading = words.reading
    assert reading is not None
    turn.tell_words(words)
    intent = reading.intent
    believed = claims.add_claim(turn, reading)
    if intent in MOVES - STOPPING and _is_overruled(turn, _said_s(turn, words)):
        _dismiss(turn, words, "somebody has just called a stop")
        return
    if turn.state.letting_out and intent in STOPPING:
        _dismiss(turn, words, "the vehicle stands already")
        return
    if intent in (GuidanceIntent.YES, GuidanceIntent.NO) and _is_answered(turn, intent, words):
        return
    if intent in STAYS:
        turn.state = replace(turn.state, stop_said_s=_said_s(turn, words))
    if intent is GuidanceIntent.NONE and _warns_a_plan(turn, reading):
        _take(turn, words)
        _hold_back(turn, reading)
    elif intent is GuidanceIntent.NONE:
        told = ", ".join(claim.value.replace("_", " ") for claim in reading.claims)
        _dismiss(turn, words, f"taken into account: {told}" if believed else "nothing is asked of the driving")
    elif intent is GuidanceIntent.UNLAWFUL:
        _dismiss(turn, words, "refused: that is not allowed")
    elif intent in (GuidanceIntent.UNCLEAR, GuidanceIntent.YES):
        _ask_back(turn, words)
    else:
        _take(turn, words)
        turn.state = replace(turn.state, clarification_asked=False)
        if intent in STAYS and turn.state.words is not None:
            _hold_back(turn, reading)


def _said_s(turn: PendingTransition, words: Guidance) -> float:
    """When the words were said (s, the solver's own time)."""
    return words.time_s + turn.inputs.offset_s


def _is_overruled(turn: PendingTransition, said_s: float) -> bool:
    """True if a call to stop was said at about the same time, or later: the stop wins, whoever says the rest."""
    stop_s = turn.state.stop_said_s
    return stop_s is not None and said_s - stop_s < STOP_WINS_S


def _overrule_yes(turn: PendingTransition) -> None:
    """Drop a yes to a question, a passenger's or an operator's, if a stop was called at about the same time."""
    reply = turn.reply
    if reply is not None and reply.yes and _is_overruled(turn, turn.now_s):
        turn.tell(EventKind.ANSWERED, f"{reply.by}: yes, but somebody has just called a stop", question=reply.question)
        turn.reply = None


def _warns_a_plan(turn: PendingTransition, reading: Interpretation) -> bool:
    """True if somebody says that the way is not clear while a plan runs, or waits for a gap."""
    warns = Claim.NOT_CLEAR in reading.claims and not reading.negated
    return warns and isinstance(turn.state.activity, Executing | AwaitingGap)


def _is_answered(turn: PendingTransition, intent: GuidanceIntent, words: Guidance) -> bool:
    """Take yes or no as the answer to the passenger's open question, if it is one that a yes answers."""
    question = answerable_question(turn.state)
    if question is None or words.time_s < question.time_s:
        return False  # what was said before the question was asked is no answer to it
    turn.reply = PersonReply(question, intent is GuidanceIntent.YES, "passenger")
    _dismiss(turn, words, f"answers question {question.id}")
    return True


def _take(turn: PendingTransition, words: Guidance) -> None:
    """Follow these words from now on and drop everything that was about to be done for another reason."""
    state = turn.state
    if state.letting_out and words.reading is not None and words.reading.intent in REQUESTS:
        turn.state = replace(
            turn.state, letting_out=False, detector_ignored_until_s=turn.now_s
        )  # it stood because somebody got out
    turn.state = replace(
        turn.state,
        words=ActiveGuidance(words, turn.now_s),
        guidance_escalation=state.guidance_escalation.reset(),
        escalation=replace(state.escalation, quiet_until_s=turn.now_s),
        history=state.history.without_attempts(),
    )
    if isinstance(state.activity, AwaitingGap):
        turn.state = replace(turn.state, activity=Monitoring())
    turn.drop_query()
    if state.question is not None and state.question.kind is not QuestionKind.ASSISTANCE:
        turn.withdraw_question()
    if isinstance(state.posture, MinimalRisk) and resumes(turn) is Resume.OPERATOR:
        end_words(turn, "only the operator may end this stop")


def _hold_back(turn: PendingTransition, reading: Interpretation) -> None:
    """The words ask to stay: a running plan ends by its safe abort, and nothing begins for now.

    A refusal holds until other words are said or the intervention ends; a "wait" holds for the time that was named, or
    else until it expires.
    """
    running = turn.state.activity
    if isinstance(running, Executing):
        turn.state = replace(
            turn.state, activity=replace(running, execution=running.execution.withdrawn(), withdrawn=True)
        )
    refuses = reading.negated or reading.intent in (GuidanceIntent.NO, GuidanceIntent.FOLLOW)
    named_s = None if reading.limits is None else reading.limits.wait_s
    wait_s = turn.setup.ladder.words.expire_s if named_s is None else max(named_s, LEAST_WAIT_S)
    until = math.inf if refuses or turn.state.letting_out else turn.now_s + wait_s
    turn.state = replace(turn.state, escalation=replace(turn.state.escalation, quiet_until_s=until))
    end_words(turn, "the plan is given up" if isinstance(running, Executing) else "nothing is begun")


def _ask_back(turn: PendingTransition, words: Guidance) -> None:
    """Unclear words move nothing; ask the passenger once what was meant."""
    _dismiss(turn, words, "not understood")
    if not turn.state.clarification_asked:
        turn.state = replace(turn.state, clarification_asked=True)
        turn.tell(EventKind.ASKED_BACK, turn.setup.ask_back)


def _dismiss(turn: PendingTransition, words: Guidance, how: str) -> None:
    turn.tell(EventKind.GUIDANCE_ENDED, f'"{words.text}": {how}')
