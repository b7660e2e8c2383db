"""The rungs of a ladder: their parameters with bounds, and what each asks of the solver.

A new kind of rung is one class here and its name in `AnyRung` and `KINDS`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from stucksolver.ladder.rung_actions import AskPerson, AskReasoner, CallAssistance, CheckForWait, Move, Resume
from stucksolver.scene.base_model import FrozenModel


class Rung(FrozenModel, ABC):
    """One rung of a ladder: a table in its file."""

    summary: ClassVar[str]
    """One sentence that says what it does. Shown by `stucksolver ladder`."""

    kind: str

    @abstractmethod
    def move(self) -> Move:
        """Return what the solver must do on this rung."""


class WaitRung(Rung):
    """Waits if a light, a queue or people hold the vehicle up. The table `waits` says how long that is right."""

    summary: ClassVar[str] = "wait while a light, a queue, people or a duty to yield make waiting right"

    kind: Literal["wait"] = "wait"

    def move(self) -> CheckForWait:
        return CheckForWait()


class RulesRung(Rung):
    """The built-in rules, or the reasoner that replaces them."""

    summary: ClassVar[str] = "ask the rules for a plan, which the guard checks"

    kind: Literal["rules"] = "rules"
    deadline_s: float = Field(default=5.0, gt=0, le=600)
    """A later answer is dropped (s)."""
    tries: int = Field(default=5, ge=1, le=1000)
    """Number of plans or answers without success before the next rung."""
    cooldown_s: float = Field(default=2.0, ge=0.1, le=600)
    """Time between two tries (s)."""
    repair_rounds: int = Field(default=1, ge=0, le=5)
    """How often a reasoner whose plan was refused is told why and asked again at once."""

    def move(self) -> AskReasoner:
        return AskReasoner("rules", self.deadline_s, self.tries, self.cooldown_s, self.repair_rounds)


class DistilledRung(Rung):
    """The small network that comes with the package, or one of the user's own. The solver loads it by itself."""

    summary: ClassVar[str] = "ask the student, a small network on the CPU, for a plan, which the guard checks"

    kind: Literal["distilled"] = "distilled"
    weights: str = ""
    """Folder of the weights; empty for those that come with the package."""
    deadline_s: float = Field(default=1.0, gt=0, le=600)
    tries: int = Field(default=3, ge=1, le=1000)
    cooldown_s: float = Field(default=2.0, ge=0.1, le=600)
    repair_rounds: int = Field(default=1, ge=0, le=5)

    def move(self) -> AskReasoner:
        name = f"{self.kind}:{self.weights}" if self.weights else self.kind
        return AskReasoner(name, self.deadline_s, self.tries, self.cooldown_s, self.repair_rounds)


class ModelRung(Rung):
    """A language model, or any reasoner that the stack registers under this name; skipped if there is none."""

    summary: ClassVar[str] = "ask a model for a plan, which the guard checks; skipped where no model is given"

    kind: Literal["model"] = "model"
    reasoner: str = "model"
    """Its name among the stack's reasoners."""
    deadline_s: float = Field(default=5.0, gt=0, le=600)
    tries: int = Field(default=3, ge=1, le=1000)
    cooldown_s: float = Field(default=3.0, ge=0.1, le=600)
    repair_rounds: int = Field(default=1, ge=0, le=5)

    def move(self) -> AskReasoner:
        return AskReasoner(self.reasoner, self.deadline_s, self.tries, self.cooldown_s, self.repair_rounds)


class PassengerRung(Rung):
    """Asks the passenger what to do. The answer comes as words (`StuckSolver.guide`)."""

    summary: ClassVar[str] = "ask the passenger what to do, and go on looking meanwhile"

    kind: Literal["passenger"] = "passenger"
    within_s: float = Field(default=30.0, gt=0, le=3600)
    """Time to wait for an answer before the next rung (s)."""
    look_every_s: float = Field(default=5.0, ge=0.5, le=600)

    def move(self) -> AskPerson:
        return AskPerson("passenger", self.within_s, self.look_every_s)


class RemoteRung(Rung):
    """Switches on the hazard lights, pulls over if a plan for that is accepted, stops, and calls for help."""

    summary: ClassVar[str] = "pull over where that is safe, stop with hazard lights, call for remote assistance"

    kind: Literal["remote"] = "remote"
    pull_over: bool = True
    """Pull over to the roadside before stopping, if the guard accepts that."""
    look_every_s: float = Field(default=10.0, ge=0.5, le=600)
    resume: Resume = Resume.CLEAR

    def move(self) -> CallAssistance:
        return CallAssistance(self.pull_over, self.look_every_s, self.resume)


AnyRung = Annotated[
    WaitRung | RulesRung | DistilledRung | ModelRung | PassengerRung | RemoteRung, Field(discriminator="kind")
]

KINDS: dict[str, type[Rung]] = {
    cls.model_fields["kind"].default: cls
    for cls in (WaitRung, RulesRung, DistilledRung, ModelRung, PassengerRung, RemoteRung)
}
