"""Ask the student."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.ladder.rung_actions import AskReasoner
from stucksolver.ladder.rungs.base import Rung


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
