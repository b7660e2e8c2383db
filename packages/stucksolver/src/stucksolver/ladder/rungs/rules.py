"""Ask the rules."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.ladder.rung_actions import AskReasoner
from stucksolver.ladder.rungs.base import Rung


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
