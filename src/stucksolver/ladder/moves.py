"""What a rung may ask of the solver: a closed list, so that a new kind of rung needs no change in the solver."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Literal

Person = Literal["passenger", "operator"]


class Resume(str, Enum):
    """What ends the stop of the last rung."""

    OPERATOR = "operator"
    """Only the operator's yes."""
    CLEAR = "clear"
    """The operator's yes, a passenger's words that lead to an accepted plan, or a free way."""
    PLAN = "plan"
    """All of these, or a plan of the first reasoner that the guard accepts."""


@dataclass(frozen=True)
class Screen:
    """Check by rules whether waiting is right, now and before every question of the higher rungs."""


@dataclass(frozen=True)
class AskReasoner:
    """Ask a reasoner, try its plans, and climb when the tries are used up."""

    reasoner: str
    deadline_s: float
    tries: int
    cooldown_s: float
    repair_rounds: int


@dataclass(frozen=True)
class AskPerson:
    """Ask a person a question for a limited time, and keep looking meanwhile."""

    to: Person
    within_s: float
    look_every_s: float


@dataclass(frozen=True)
class Assist:
    """Stop in the minimal risk condition and call for help."""

    pull_over: bool
    """Leave the road first, if a plan for that is accepted."""
    look_every_s: float
    resume: Resume


Move = Screen | AskReasoner | AskPerson | Assist
