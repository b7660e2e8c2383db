"""What the guard says of a plan."""

from __future__ import annotations

from stucksolver.decision.behaviors import Abort, CannotPlan
from stucksolver.scene.attempts import PlanFailure, RejectCode
from stucksolver.scene.model import Model


class Reject(Model):
    """One reason against a plan, with the offending object, when, and how near, where that applies."""

    code: RejectCode
    detail: str
    object_id: str | None = None
    time_s: float | None = None
    gap_m: float | None = None
    failure: PlanFailure | None = None
    """Why there is no path, with `RejectCode.NO_PATH`."""
    needed_m: float | None = None
    """How far must be seen, with `RejectCode.ONCOMING_SIGHT`; `time_s` is then the time in which somebody may come."""
    seen_m: float | None = None
    """How far is seen, with the same."""


class SightProof(Model):
    """Why a pass may begin: how far the oncoming lane must be seen, how far it is, for how long nobody may come."""

    needed_m: float
    seen_m: float
    unseen_s: float


class Verdict(Model):
    """`abort` is set only while a plan runs: what to do instead; `brake_mps2`: how hard, where it is to brake.

    `sight`: the proof of an accepted pass through the oncoming lane.
    """

    rejects: tuple[Reject, ...] = ()
    abort: Abort | None = None
    brake_mps2: float | None = None
    sight: SightProof | None = None

    @property
    def accepted(self) -> bool:
        """Whether no check rejects."""
        return not self.rejects

    @property
    def codes(self) -> tuple[RejectCode, ...]:
        """Why it is not accepted, each reason once."""
        return tuple(dict.fromkeys(r.code for r in self.rejects))

    @property
    def failures(self) -> tuple[PlanFailure, ...]:
        """Why there is no path, each reason once."""
        return tuple(dict.fromkeys(r.failure for r in self.rejects if r.failure is not None))

    def __str__(self) -> str:
        if self.accepted:
            return "accepted"
        return "; ".join(f"{r.code.value}: {r.detail}" for r in self.rejects)


def no_path(error: CannotPlan) -> Verdict:
    """Refuses behaviours that have no path."""
    return Verdict(rejects=(Reject(code=RejectCode.NO_PATH, detail=str(error), failure=error.failure),))


OK = Verdict()
