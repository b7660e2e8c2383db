"""Actions that a rung may request from the solver: a closed list, so that a new kind of rung needs no solver change."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Literal

from stucksolver.query_budget import QueryBudget

Person = Literal["passenger", "operator"]

FIRST_REASONER = "reasoner"
"""Name of the first reasoner on a ladder: the built-in search, or the one that replaces it."""


class Resume(str, Enum):
    """Event that ends the stop on the last rung."""

    OPERATOR = "operator"
    """Only the operator's approval."""
    CLEAR = "clear"
    """The operator's approval, guidance that leads to an accepted plan, a free path, or the limit of the stop."""
    PLAN = "plan"
    """Any of these, or a plan of the first reasoner that the guard accepts."""


@dataclass(frozen=True)
class CheckForWait:
    """Check the duties for a legitimate wait, now and before every query on the higher rungs."""


@dataclass(frozen=True)
class AskReasoner:
    """Query a reasoner, try its plans, and escalate when the tries are used up."""

    reasoner: str
    deadline_s: float
    tries: int
    cooldown_s: float
    repair_rounds: int
    budget: QueryBudget | None = None
    """Bounds on the use of the reasoner in one intervention; None for its own."""


@dataclass(frozen=True)
class AskPerson:
    """Ask a person a question, wait a limited time for the reply, and keep checking the scene meanwhile."""

    to: Person
    within_s: float
    look_every_s: float


@dataclass(frozen=True)
class CallAssistance:
    """Stop in the minimal risk condition and call for assistance."""

    pull_over: bool
    """True to pull over first, if the guard accepts a plan for that."""
    look_every_s: float
    resume: Resume


Move = CheckForWait | AskReasoner | AskPerson | CallAssistance
