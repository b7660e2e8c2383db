"""What a running plan tells the stack at one tick, or how it ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache

from stucksolver.guard import OK, Verdict
from stucksolver.plan import Execute, Replan, SafeStop
from stucksolver.plan.behaviors import Wait


class NextStep(str, Enum):
    """Why a later step of a plan did not begin."""

    REFUSED = "refused"
    TIMED_OUT = "timed out"
    """Only traffic prevented it, for too long."""


@dataclass(frozen=True)
class ExecutionOutcome:
    """How a plan ended."""

    finished: bool
    text: str
    verdict: Verdict = field(default=OK, compare=False)
    """The verdict if the guard ended the plan. A record keeps it in the tick's own verdict."""
    next_step: NextStep | None = field(default=None, compare=False)
    """Why a later step did not begin once an earlier one was done; None if the plan ended otherwise."""

    def recorded(self) -> dict[str, object]:
        """What a record keeps of the outcome."""
        return {"finished": self.finished, "text": self.text}


Step = Execute | Replan | SafeStop
STAND = Execute(behavior=Wait(duration_s=1.0))
"""Brake and stand until crossing traffic has passed or the stack can drive on by itself."""


@lru_cache(maxsize=8)
def stand(brake_mps2: float | None) -> Execute:
    """The same with a given deceleration (m/s²), if there is one."""
    return STAND if brake_mps2 is None else STAND.model_copy(update={"brake_mps2": brake_mps2})
