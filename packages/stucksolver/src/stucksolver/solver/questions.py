"""Questions to people: what is asked, the deadline, and the reply."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from enum import Enum

from stucksolver.ladder.rung_actions import Person
from stucksolver.plan import RecoveryPlan
from stucksolver.scene.base_model import FrozenModel


class QuestionKind(str, Enum):
    """What a person is asked for."""

    APPROVAL = "approval"
    """May this plan be driven? Answered by `approve` or `deny`."""
    ADVICE = "advice"
    """What shall I do? Answered by words (`guide`)."""
    ASSISTANCE = "assistance"
    """The vehicle stands in its minimal risk condition. `approve` lets it try again."""


class Question(FrozenModel):
    """One question, in the form that a page shows."""

    id: str
    time_s: float
    kind: QuestionKind
    to: Person
    text: str
    plan: RecoveryPlan | None = None
    needs: tuple[str, ...] = ()
    """What a yes would release: names of behaviors or rules, for example `solid_line`."""
    within_s: float | None = None
    """The question is withdrawn after this time; None if it stays open."""


@dataclass(frozen=True)
class PersonReply:
    """A person's yes or no to a question."""

    question: Question
    yes: bool
    by: Person


class QuestionError(ValueError):
    """A reply without an open question, or from the wrong person. The message says what is asked."""


class QuestionDesk:
    """Shows the open question and takes the reply. May be called from any thread."""

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
        """Take a reply; it counts from the next step on.

        Args:
            yes: The answer.
            question_id: Id of the question, or None for the open one.
            by: Who answers.

        Raises:
            QuestionError: Nothing is asked, another question is open, or it is for another person.
        """
        with self._lock:
            question = self.pending
            if question is None:
                raise QuestionError("nothing is asked now")
            if question_id is not None and question_id != question.id:
                raise QuestionError(f"question {question_id} is no longer open; the open one is {question.id}")
            if question.kind is QuestionKind.ADVICE:
                raise QuestionError(f"question {question.id} asks for words: call guide(text)")
            if question.to == "operator" and by != "operator":
                raise QuestionError(f"question {question.id} is for the operator")
            if self._reply is None or not yes:  # of two people who contradict each other, the no wins
                self._reply = PersonReply(question, yes, by)

    def take(self) -> PersonReply | None:
        """Return the reply to the open question once; None while there is none."""
        with self._lock:
            reply, self._reply = self._reply, None
            return reply
