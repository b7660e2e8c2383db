"""Rungs of a ladder: their parameters with bounds, and the action that each requests from the solver.

A new kind of rung is one class here and its name in `AnyRung` and `KINDS`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from stucksolver.ladder.rung_actions import (
    FIRST_REASONER,
    AskPerson,
    AskReasoner,
    CallAssistance,
    CheckForWait,
    Move,
    Resume,
)
from stucksolver.query_budget import QueryBudget
from stucksolver.scene.base_model import FrozenModel

DEADLINE_S = 10.0
"""Deadline of a reasoner's answer (s).

A language model may query the guard twice before it decides: three exchanges of 2.8 s (Bao & Li 2025) take 8.4 s.
"""


class Rung(FrozenModel, ABC):
    """One rung of a ladder: a table in its file."""

    summary: ClassVar[str]
    """One sentence about the rung, shown by `stucksolver ladder`."""

    kind: str

    @abstractmethod
    def move(self) -> Move:
        """Return the solver's action on this rung."""


class WaitRung(Rung):
    """Rung that waits for a light, a queue or people. The table `waits` has the limits of a legitimate wait."""

    summary: ClassVar[str] = "wait for a light, a queue, people or a duty to yield while that is legitimate"

    kind: Literal["wait"] = "wait"

    def move(self) -> CheckForWait:
        return CheckForWait()


class ReasonerRung(Rung):
    """Rung of the first reasoner: the built-in search, or the reasoner that replaces it."""

    summary: ClassVar[str] = "query the reasoner for a plan, which the guard checks"

    kind: Literal["reasoner"] = "reasoner"
    deadline_s: float = Field(default=DEADLINE_S, gt=0, le=600)
    """Deadline of an answer (s); a later answer is dropped."""
    tries: int = Field(default=5, ge=1, le=1000)
    """Number of plans or answers without success before the next rung. Ours."""
    cooldown_s: float = Field(default=2.0, ge=0.1, le=600)
    """Time between two tries (s). Ours."""
    repair_rounds: int = Field(default=1, ge=0, le=5)
    """Number of times that a reasoner gets the reject reasons of its plan and is queried again at once. Ours."""
    budget: QueryBudget | None = None
    """Bounds on the reasoner that replaces the search, as on the rung `model`."""

    def move(self) -> AskReasoner:
        return AskReasoner(
            FIRST_REASONER, self.deadline_s, self.tries, self.cooldown_s, self.repair_rounds, self.budget
        )


class ModelRung(Rung):
    """Rung of a language model, or of any reasoner that the stack registers under its name; skipped without one."""

    summary: ClassVar[str] = "query a model for a plan, which the guard checks; skipped without a model"

    kind: Literal["model"] = "model"
    reasoner: str = "model"
    """Name of the reasoner in the stack."""
    deadline_s: float = Field(default=DEADLINE_S, gt=0, le=600)
    tries: int = Field(default=3, ge=1, le=1000)
    cooldown_s: float = Field(default=3.0, ge=0.1, le=600)
    repair_rounds: int = Field(default=1, ge=0, le=5)
    budget: QueryBudget | None = None
    """Bounds on queries, tokens and US dollars in one intervention. None for those of the reasoner."""

    def move(self) -> AskReasoner:
        return AskReasoner(self.reasoner, self.deadline_s, self.tries, self.cooldown_s, self.repair_rounds, self.budget)


class PassengerRung(Rung):
    """Rung that asks the passenger. The reply comes as guidance (`StuckSolver.guide`)."""

    summary: ClassVar[str] = "ask the passenger what to do, and keep checking the scene meanwhile"

    kind: Literal["passenger"] = "passenger"
    within_s: float = Field(default=30.0, gt=0, le=3600)
    """Time to wait for a reply before the next rung (s). Ours."""
    look_every_s: float = Field(default=5.0, ge=0.5, le=600)

    def move(self) -> AskPerson:
        return AskPerson("passenger", self.within_s, self.look_every_s)


class RemoteRung(Rung):
    """Rung that sets the hazard lights, pulls over if the guard accepts that, stops, and calls for assistance."""

    summary: ClassVar[str] = "pull over where that is safe, stop with hazard lights, call for remote assistance"

    kind: Literal["remote"] = "remote"
    pull_over: bool = True
    """True to pull over to the roadside before stopping, if the guard accepts that."""
    look_every_s: float = Field(default=10.0, ge=0.5, le=600)
    resume: Resume = Resume.CLEAR

    def move(self) -> CallAssistance:
        return CallAssistance(self.pull_over, self.look_every_s, self.resume)


AnyRung = Annotated[WaitRung | ReasonerRung | ModelRung | PassengerRung | RemoteRung, Field(discriminator="kind")]

KINDS: dict[str, type[Rung]] = {
    cls.model_fields["kind"].default: cls for cls in (WaitRung, ReasonerRung, ModelRung, PassengerRung, RemoteRung)
}
