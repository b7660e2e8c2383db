"""What a rung may ask of the solver: a closed list, so that a new kind of rung needs no change in the solver."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Literal

Person = Literal["passenger", "operator"]


class Resume(str, Enum):
    """What ends the stop of the last rung."""

    OPERATOR = "operator"
    """Only the operator's approval."""
    CLEAR = "clear"
    """The operator's approval, a passenger's words that lead to an accepted plan, a free path, or the stop's limit."""
    PLAN = "plan"
    """Any of these, or a plan of the first reasoner that the guard accepts."""


@dataclass(frozen=True)
class CheckForWait:
    """Check by the rules whether waiting is right, now and before every question on the higher rungs."""


@dataclass(frozen=True)
class AskReasoner:
    """Ask a reasoner, try its plans, and go to the next rung when the tries are used up."""

    reasoner: str
    deadline_s: float
    tries: int
    cooldown_s: float
    repair_rounds: int


@dataclass(frozen=True)
class AskPerson:
    """Ask a person a question, wait a limited time for the answer, and keep checking the scene meanwhile."""

    to: Person
    within_s: float
    look_every_s: float


@dataclass(frozen=True)
class CallAssistance:
    """Stop in the minimal risk condition and call for help."""

    pull_over: bool
    """Pull over first, if the guard accepts a plan for that."""
    look_every_s: float
    resume: Resume


Move = CheckForWait | AskReasoner | AskPerson | CallAssistance
