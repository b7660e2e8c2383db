"""Questions to people, with their deadlines and replies."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from enum import Enum

from stucksolver.ladder.rung_actions import Person
from stucksolver.plan import RecoveryPlan
from stucksolver.scene.base_model import FrozenModel


class QuestionKind(str, Enum):
    """Kind of a question."""

    APPROVAL = "approval"
    """May this plan be driven? The reply is `approve` or `deny`."""
    ADVICE = "advice"
    """What shall I do? The reply is an utterance (`guide`)."""
    ASSISTANCE = "assistance"
    """The vehicle has stopped in its minimal risk condition. `approve` lets it try again."""


class Question(FrozenModel):
    """One question, in the form for a page."""

    id: str
    time_s: float
    kind: QuestionKind
    to: Person
    text: str
    plan: RecoveryPlan | None = None
    needs: tuple[str, ...] = ()
    """Behaviors or rules that a yes approves, for example `solid_line`."""
    within_s: float | None = None
    """Time after which the question is withdrawn (s); None if it stays open."""


@dataclass(frozen=True)
class PersonReply:
    """Reply of a person to a question: yes or no."""

    question: Question
    yes: bool
    by: Person


class QuestionError(ValueError):
    """Reply without an open question, or from the wrong person. The message has the open question."""


class QuestionDesk:
    """Holder of the open question and its reply. May be used from any thread."""

    def __init__(self) -> None:
        self.pending: Question | None = None
        self._reply: PersonReply | None = None
        self._lock = threading.Lock()

    def show(self, question: Question | None) -> None:
        """Set the open question. A reply to the previous question no longer counts."""
        with self._lock:
            if question != self.pending:
                self.pending, self._reply = question, None

    def reply(self, yes: bool, question_id: str | None, by: Person) -> None:
        """Store a reply; it counts from the next step on.

        Args:
            yes: Reply.
            question_id: Id of the question, or None for the open one.
            by: Person who replies.

        Raises:
            QuestionError: No question is open, another question is open, or the question is for another person.
        """
        with self._lock:
            question = self.pending
            if question is None:
                raise QuestionError("no question is open")
            if question_id is not None and question_id != question.id:
                raise QuestionError(f"question {question_id} is no longer open; the open one is {question.id}")
            if question.kind is QuestionKind.ADVICE:
                raise QuestionError(f"question {question.id} requires an utterance: call guide(text)")
            if question.to == "operator" and by != "operator":
                raise QuestionError(f"question {question.id} is for the operator")
            if self._reply is None or not yes:  # If two people contradict each other, the no counts.
                self._reply = PersonReply(question, yes, by)

    def take(self) -> PersonReply | None:
        """Return the reply to the open question once; None without a reply."""
        with self._lock:
            reply, self._reply = self._reply, None
            return reply
