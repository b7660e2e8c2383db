"""What a rung may ask of the solver: a closed list, so that a new kind of rung needs no change in the solver."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Literal

Person = Literal["passenger", "operator"]


class Resume(str, Enum):
    """What ends the stop of the last rung."""

    OPERATOR = "operator"
    """The operator's yes, and nothing else."""
    CLEAR = "clear"
    """That, a passenger's words that lead to an accepted plan, or the way being free again."""
    PLAN = "plan"
    """All that, or a plan of the first reasoner that the guard accepts."""


@dataclass(frozen=True)
class Screen:
    """Look by rules whether waiting is right, now and before every question of the rungs above."""


@dataclass(frozen=True)
class AskReasoner:
    """Ask a reasoner, try its plans, and climb on when the tries are used up."""

    reasoner: str
    deadline_s: float
    tries: int
    cooldown_s: float
    repair_rounds: int


@dataclass(frozen=True)
class AskPerson:
    """Put a question to a person, for so long; look for oneself meanwhile."""

    to: Person
    within_s: float
    look_every_s: float


@dataclass(frozen=True)
class Assist:
    """Stop in the minimal risk condition and call for help."""

    pull_over: bool
    """Off the road first, where a plan for that is accepted."""
    look_every_s: float
    resume: Resume


Move = Screen | AskReasoner | AskPerson | Assist
