"""Ask a model."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.ladder.rung_actions import AskReasoner
from stucksolver.ladder.rungs.base import Rung


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
