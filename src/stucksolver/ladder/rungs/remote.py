"""Ask for remote assistance, in the minimal risk condition."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field, field_validator

from stucksolver.decision.behaviors import REGISTRY
from stucksolver.ladder.moves import Assist, Resume
from stucksolver.ladder.rungs.base import Rung


class RemoteRung(Rung):
    """Hazard lights, off the road where a plan for that is accepted, stopped, and a call for help."""

    summary: ClassVar[str] = "pull over where that is safe, stop with hazard lights, call for remote assistance"

    kind: Literal["remote"] = "remote"
    before: tuple[str, ...] = ()
    """Behaviours tried before the stop; the first that the guard accepts is performed."""
    look_every_s: float = Field(default=10.0, ge=0.5, le=600)
    resume: Resume = Resume.CLEAR

    @field_validator("before")
    @classmethod
    def _known(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        for name in names:
            if name not in REGISTRY:
                raise ValueError(f"unknown behaviour {name!r}; there are: {', '.join(REGISTRY)}")
        return names

    def move(self) -> Assist:
        return Assist(self.before, self.look_every_s, self.resume)
