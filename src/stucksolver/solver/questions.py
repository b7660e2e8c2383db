"""Questions to people: what is asked, by when, and what they say."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from enum import Enum

from stucksolver.decision import RecoveryPlan
from stucksolver.ladder.moves import Person
from stucksolver.scene.model import Model


class QuestionKind(str, Enum):
    APPROVAL = "approval"
    """May this plan be driven? Answered by `approve` or `deny`."""
    ADVICE = "advice"
    """What shall I do? Answered by words (`guide`)."""
    ASSISTANCE = "assistance"
    """The vehicle stands in its minimal risk condition. `approve` lets it try again."""


class Question(Model):
    """One question, for a page to show."""

    id: str
    time_s: float
    kind: QuestionKind
    to: Person
    text: str
    plan: RecoveryPlan | None = None
    needs: tuple[str, ...] = ()
    """What the yes would release: names of behaviours or of rules, as `solid_line`."""
    within_s: float | None = None
    """It is withdrawn after so long; None: it stays."""


@dataclass(frozen=True)
class Reply:
    """A person's yes or no to a question."""

    question: Question
    yes: bool
    by: Person


class QuestionError(ValueError):
    """An answer to no question, or by the wrong person; the message says what is asked."""


class Desk:
    """Holds the one question that is open. `reply` may be called from any thread."""

    def __init__(self) -> None:
        self.pending: Question | None = None
        self.reply_given: Reply | None = None
        self._count = 0
        self._opened_s = 0.0
        self._lock = threading.Lock()

    def next_id(self) -> str:
        self._count += 1
        return f"q{self._count}"

    def open(self, question: Question, now_s: float) -> Question:
        """Ask something, in the solver's own time; it replaces what was asked before."""
        with self._lock:
            self.pending, self.reply_given, self._opened_s = question, None, now_s
        return question

    def expired(self, now_s: float) -> bool:
        """Has nobody answered the open question in time?"""
        question = self.pending
        return question is not None and question.within_s is not None and now_s - self._opened_s > question.within_s

    def reply(self, yes: bool, question_id: str | None, by: Person) -> None:
        """Take an answer; it counts from the next step on. Raises `QuestionError`."""
        with self._lock:
            question = self.pending
            if question is None:
                raise QuestionError("nothing is asked now")
            if question_id is not None and question_id != question.id:
                raise QuestionError(f"question {question_id} is not open any more; open is {question.id}")
            if question.kind is QuestionKind.ADVICE:
                raise QuestionError(f"question {question.id} asks for words: call guide(text)")
            if question.to == "operator" and by != "operator":
                raise QuestionError(f"question {question.id} is for the operator")
            self.reply_given = Reply(question, yes, by)

    def take(self) -> Reply | None:
        """The reply to the open question, which is closed by that; None while there is none."""
        if self.reply_given is None:
            return None
        with self._lock:
            reply, self.reply_given, self.pending = self.reply_given, None, None
            return reply

    def withdraw(self) -> Question | None:
        """Close the open question without an answer; gives it back."""
        with self._lock:
            question, self.pending, self.reply_given = self.pending, None, None
            return question
