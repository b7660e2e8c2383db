"""Stores the conversation: converts the solver's events to lines for a passenger."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from stucksolver.interpreter import NoInterpreter
from stucksolver.plan import plan_matches_intent
from stucksolver.plan.behaviors import REGISTRY
from stucksolver.scene import GuidanceIntent, Interpretation
from stucksolver.scene.interpretation import REQUESTS, STAYS
from stucksolver.solver import Event, EventKind, Question, QuestionKind
from stucksolver.solver.state_machine.guidance import answerable_question
from stucksolver.solver.state_machine.state import AwaitingApproval, Executing, State
from stucksolver_passenger.api_types import ConversationLine, Speaker
from stucksolver_passenger.sentences.acknowledgements import (
    ASKED_BACK,
    NOBODY_READS,
    NOTHING_TO_STOP,
    YES_OR_NO,
    acknowledged,
)
from stucksolver_passenger.sentences.plans import present_phrase
from stucksolver_passenger.sentences.questions import question_text
from stucksolver_passenger.sentences.reasons import blocked_by, standstill_sentence, waiting
from stucksolver_passenger.sentences.rejections import abort_sentence, rejection_sentence


def implies_approval(reading: Interpretation | None, question: Question | None) -> bool:
    """True if the passenger has already requested this plan.

    "Please go round it" needs no further question "May I go round it?". That holds only if the yes approves nothing but
    the plan's behaviors. For a rule of the road, such as a solid line, the question remains.
    """
    if question is None or question.to != "passenger" or question.kind is not QuestionKind.APPROVAL:
        return False
    only_behaviors = all(name in REGISTRY for name in question.needs)
    return question.plan is not None and only_behaviors and plan_matches_intent(reading, question.plan)


MAX_LINES = 200
"""Maximum number of lines of a conversation in memory. Ours."""
FINISHED_M = 5.0
"""Progress after a withdrawal from which a plan counts as finished (m).

It had passed the point where a stop was safe. Ours.
"""
FINISHED = "I could not stop safely half-way, so I have finished it."
OPEN_ENDED = (GuidanceIntent.UNCLEAR, GuidanceIntent.YES)
"""Intents to which the solver responds with one question."""


class Conversation:
    """The lines of one vehicle.

    The thread that drives the vehicle calls `hear`; any thread may call `add_utterance`. `state` returns the solver's
    state after the step that an event belongs to.
    """

    def __init__(self, state: Callable[[], State | None]) -> None:
        self._state = state
        self._lines: deque[ConversationLine] = deque(maxlen=MAX_LINES)
        self._number = 0
        self._lock = threading.Lock()
        self._request: GuidanceIntent | None = None
        """The last request, until it has an effect."""
        self._asked_back = self._nobody_reads = False
        self._agreed = False
        """True if the passenger's own utterance has answered the last question."""
        self._withdrawn = False
        """True if an utterance withdrew the running plan."""
        self.moving = False
        """True if the car moves. The driving thread sets this field and the next one."""
        self.progress_m = 0.0
        self._withdrawn_m = 0.0
        """Progress at the withdrawal of a plan (m)."""
        self._replied: set[str] = set()
        """Replies to the current utterance. They are not repeated."""
        self.readings = 0
        """Number of interpreted utterances."""
        self.decided: Event | None = None
        """The last decision event."""
        self.stays: GuidanceIntent | None = None
        """Intent that keeps the car stopped. The reader of this field resets it."""

    def lines(self, last: int) -> tuple[ConversationLine, ...]:
        """Return the newest lines, the newest last."""
        with self._lock:
            return tuple(self._lines)[-last:]

    def add_utterance(self, speaker: Speaker, text: str, time_s: float) -> None:
        """Add a person's utterance, or the press of a button."""
        self._add(speaker, text, time_s)

    def hear(self, event: Event) -> None:
        """Receive an event of the solver."""
        handler = _HANDLERS.get(event.kind)
        text = None if handler is None else handler(self, event)
        if text:
            self.tell(text, event.time_s)

    def tell(self, text: str, time_s: float) -> None:
        """Add a line of the car, unless it repeats the last line."""
        with self._lock:
            last = self._lines[-1] if self._lines else None
        if last is None or last.speaker is not Speaker.CAR or last.text != text:
            self._add(Speaker.CAR, text, time_s)

    # ---- meaning of each event for a passenger; None if it needs no line

    def _guidance(self, event: Event) -> str | None:
        reading = event.reading
        assert reading is not None
        self.readings += 1
        self._replied.clear()
        self._mark_read(event, reading.description)
        self._withdrawn = False
        self._nobody_reads = reading.reader == NoInterpreter.name
        if reading.intent in OPEN_ENDED and not self._asked_back:
            return None  # the solver asks a question in the same step
        if reading.intent in REQUESTS:
            self._request, self._asked_back = reading.intent, False
        if reading.intent in STAYS:
            self._request, self._asked_back, self.stays = None, False, reading.intent
            state = self._state()
            if state is not None and isinstance(state.activity, Executing) and state.activity.withdrawn:
                self._withdrawn, self._withdrawn_m = True, self.progress_m
                return "All right. I am ending this as soon as that is safe."
            if self.moving and reading.intent in (GuidanceIntent.WAIT, GuidanceIntent.CANCEL):
                return NOTHING_TO_STOP
        return acknowledged(reading)

    def _mark_read(self, event: Event, understood: str) -> None:
        """Complete the line of this utterance. An utterance from another source gets a new line."""
        with self._lock:
            unread = (item for item in self._lines if item.text == event.text and item.understood is None)
            line = next((item for item in unread if item.speaker is not Speaker.CAR), None)
        if line is None:
            line = self._add(Speaker.PASSENGER, event.text, event.time_s)
        read = line.model_copy(update={"understood": understood})
        with self._lock:
            self._lines = deque(
                (read if item.number == line.number else item for item in self._lines), maxlen=MAX_LINES
            )

    def _guidance_ended(self, event: Event) -> str | None:
        request, self._request = self._request, None
        return None if request is None else "That was not possible in time. Tell me again if you still want it."

    def _asks_back(self, event: Event) -> str:
        self._asked_back = True
        if self._nobody_reads:
            return NOBODY_READS
        state = self._state()
        asks = state is not None and answerable_question(state) is not None
        return YES_OR_NO if asks else ASKED_BACK

    def _made_decision(self, event: Event) -> str | None:
        self.decided = event
        state = self._state()
        asks = state is not None and isinstance(state.activity, AwaitingApproval)
        if self._request is None or asks:
            return None  # there was no request, or the question that follows contains the decision
        text = _why_not(event)
        if text is None or text in self._replied:
            return None
        self._replied.add(text)
        return text

    def _asked(self, event: Event) -> str | None:
        question = event.question
        if question is None:
            return None
        self._request = None
        state = self._state()
        self._agreed = state is not None and implies_approval(state.reading, question)
        if self._agreed:
            return None
        if question.to == "operator":
            about = "" if question.kind is QuestionKind.ASSISTANCE else f": {question_text(question)}"
            return f"I have asked the operator{about or ' for help.'}"
        return question_text(question)

    def _answered(self, event: Event) -> str | None:
        if self._agreed:
            return None
        return "Thank you. I check once more, and then I go." if event.answer else "All right, I will leave it."

    def _started(self, event: Event) -> str | None:
        self._request = self.decided = None
        state = self._state()
        activity = None if state is None else state.activity
        if not isinstance(activity, Executing):
            return None
        moving = [behavior for behavior in activity.execution.plan.behaviors if not behavior.stands_still]
        return present_phrase(moving[0]) if moving else None

    def _waits(self, event: Event) -> str | None:
        notice = event.notice
        if notice is None or notice.to != "passenger":
            return None
        return standstill_sentence(notice.reason, event.scene)

    def _finished(self, event: Event) -> str:
        return "Done. I drive on."

    def _aborted(self, event: Event) -> str:
        if self._withdrawn:
            went_on = self.progress_m - self._withdrawn_m > FINISHED_M
            return FINISHED if went_on else "I have ended that, as you asked."
        state = self._state()
        attempts = () if state is None else state.history.attempts
        return abort_sentence(attempts[-1].codes if attempts else ())

    def _cancelled(self, event: Event) -> str | None:
        question = event.question
        if question is None:
            return None
        late = question.within_s is not None and event.time_s - question.time_s >= question.within_s
        return "Nobody has answered me, so I leave it for now." if late else "Never mind, I am getting on again."

    def _add(self, speaker: Speaker, text: str, time_s: float) -> ConversationLine:
        with self._lock:
            self._number += 1
            line = ConversationLine(number=self._number, time_s=round(time_s, 2), speaker=speaker, text=text)
            self._lines.append(line)
            return line


def _why_not(event: Event) -> str | None:
    """Return the reason why a decision does not do what the passenger requested; None if it does."""
    decision, verdict = event.decision, event.verdict
    if decision is None:
        return None
    if verdict is not None and not verdict.accepted:
        return rejection_sentence(verdict, event.scene)
    if decision.plan is not None:
        return None
    wait = decision.analysis.wait
    if wait is not None:
        return "I can't do that now. " + " ".join(waiting(wait, event.scene))
    return f"I can't do that now. {blocked_by(decision.analysis.cause, event.scene)}"


Handler = Callable[[Conversation, Event], "str | None"]


def _always(text: str) -> Handler:
    return lambda conversation, event: text


_HANDLERS: dict[EventKind, Handler] = {
    EventKind.GUIDANCE: Conversation._guidance,
    EventKind.GUIDANCE_ENDED: Conversation._guidance_ended,
    EventKind.ASKED_BACK: Conversation._asks_back,
    EventKind.DECIDED: Conversation._made_decision,
    EventKind.ASKED: Conversation._asked,
    EventKind.ANSWERED: Conversation._answered,
    EventKind.STARTED: Conversation._started,
    EventKind.WAITING: Conversation._waits,
    EventKind.FINISHED: Conversation._finished,
    EventKind.ABORTED: Conversation._aborted,
    EventKind.CANCELLED: Conversation._cancelled,
    EventKind.INEFFECTIVE: _always("That did not help. I will try something else."),
    EventKind.RECOVERED: _always("We are on our way again."),
    EventKind.HELD: _always("I have stopped before we touch something."),
    EventKind.STOPPED: _always("I have stopped here and switched on the hazard lights."),
    EventKind.RELEASED: _always("I go on."),
    EventKind.FAULT: _always("Something in me does not work as it should. I am taking extra care."),
}
SILENT = frozenset(
    {
        EventKind.TRIGGERED,
        EventKind.FAILED,
        EventKind.ESCALATED,
        EventKind.CLOSED,
        EventKind.PERCEPTION_DISPUTED,
        EventKind.WAITING_ENDED,
        EventKind.QUEUE_MOVED,
    }
)
"""Events internal to the solver. Their consequences have lines of their own."""
