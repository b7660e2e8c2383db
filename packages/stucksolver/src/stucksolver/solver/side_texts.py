"""Swaps the sides in words to and from people, on a road whose surroundings are mirrored for left-hand traffic."""

from __future__ import annotations

from dataclasses import replace

from stucksolver.guard import RejectReason, Verdict
from stucksolver.scene.mirror import mirrored_reading, with_sides_swapped
from stucksolver.solver.events import Event, EventKind
from stucksolver.solver.notices import Notice
from stucksolver.solver.questions import Question
from stucksolver.solver.state_machine.inputs import GuidanceInput

WORDS_OF_PEOPLE = frozenset({EventKind.GUIDANCE, EventKind.GUIDANCE_ENDED})
"""Kinds of events whose text quotes a person."""


def swapped_event(event: Event) -> Event:
    """Return an event whose texts name the sides as people see them. Scene, decision and interpretation stay."""
    text = event.text if event.kind in WORDS_OF_PEOPLE else with_sides_swapped(event.text)
    question = None if event.question is None else swapped_question(event.question)
    verdict = None if event.verdict is None else _swapped_verdict(event.verdict)
    notice = None if event.notice is None else _swapped_notice(event.notice)
    texts = {"text": text, "question": question, "verdict": verdict, "notice": notice}
    return event.model_copy(update={**texts, "mirrored": True})


def swapped_question(question: Question) -> Question:
    """Return a question whose text names the sides as people see them."""
    return question.model_copy(update={"text": with_sides_swapped(question.text)})


def swapped_guidance(guidance: GuidanceInput) -> GuidanceInput:
    """Return an utterance whose interpretation has the side in the mirror; its text stays."""
    reading = guidance.words.reading
    if reading is None or reading.side is None:
        return guidance
    return replace(guidance, words=guidance.words.model_copy(update={"reading": mirrored_reading(reading)}))


def _swapped_notice(notice: Notice) -> Notice:
    reason = notice.reason
    reject = None if reason.reject is None else _swapped_reject(reason.reject)
    texts = {"text": with_sides_swapped(reason.text), "reject": reject}
    return notice.model_copy(update={"reason": reason.model_copy(update=texts)})


def _swapped_verdict(verdict: Verdict) -> Verdict:
    return verdict.model_copy(update={"rejects": tuple(map(_swapped_reject, verdict.rejects))})


def _swapped_reject(reject: RejectReason) -> RejectReason:
    return reject.model_copy(update={"detail": with_sides_swapped(reject.detail)})
