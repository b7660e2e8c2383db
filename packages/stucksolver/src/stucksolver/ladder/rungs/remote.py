"""Ask for remote assistance, in the minimal risk condition."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.ladder.rung_actions import CallAssistance, Resume
from stucksolver.ladder.rungs.base import Rung


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
