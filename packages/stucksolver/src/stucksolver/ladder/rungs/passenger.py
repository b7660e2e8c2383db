"""Ask the passenger."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.ladder.rung_actions import AskPerson
from stucksolver.ladder.rungs.base import Rung


class PassengerRung(Rung):
    """Asks the passenger what to do. The answer comes as words (`StuckSolver.guide`)."""

    summary: ClassVar[str] = "ask the passenger what to do, and go on looking meanwhile"

    kind: Literal["passenger"] = "passenger"
    within_s: float = Field(default=30.0, gt=0, le=3600)
    """Time to wait for an answer before the next rung (s)."""
    look_every_s: float = Field(default=5.0, ge=0.5, le=600)

    def move(self) -> AskPerson:
        return AskPerson("passenger", self.within_s, self.look_every_s)
