"""The guard's verdict on a plan."""

from __future__ import annotations

from stucksolver.plan.behaviors import AbortAction, NoPathError
from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.failed_attempts import PlanFailure, RejectCode


class RejectReason(FrozenModel):
    """One reason against a plan, with the object, the time (s from now) and the gap (m) if they apply."""

    code: RejectCode
    detail: str
    object_id: str | None = None
    time_s: float | None = None
    gap_m: float | None = None
    failure: PlanFailure | None = None
    """Why there is no path, for `RejectCode.NO_PATH`."""
    needed_m: float | None = None
    """The sight needed (m), for `RejectCode.ONCOMING_SIGHT`. `time_s` is then the time in which traffic may come."""
    seen_m: float | None = None
    """The sight available (m), for the same code."""


class SightDistanceProof(FrozenModel):
    """Why a pass may begin: the sight needed and available in the oncoming lane (m), and the unchecked time (s)."""

    needed_m: float
    seen_m: float
    unseen_s: float


class Verdict(FrozenModel):
    """The guard's verdict. A plan is accepted if there are no reasons against it.

    Attributes:
        rejects: The reasons against the plan.
        abort: What to do instead; set only while a plan runs.
        brake_mps2: How hard to brake (m/s²), if the abort is to brake.
        sight: The proof of an accepted pass through the oncoming lane.
    """

    rejects: tuple[RejectReason, ...] = ()
    abort: AbortAction | None = None
    brake_mps2: float | None = None
    sight: SightDistanceProof | None = None

    @property
    def accepted(self) -> bool:
        """True if no check refuses the plan."""
        return not self.rejects

    @property
    def codes(self) -> tuple[RejectCode, ...]:
        """The codes of the reasons, each once."""
        return tuple(dict.fromkeys(r.code for r in self.rejects))

    @property
    def failures(self) -> tuple[PlanFailure, ...]:
        """The reasons why there is no path, each once."""
        return tuple(dict.fromkeys(r.failure for r in self.rejects if r.failure is not None))

    @property
    def too_near(self) -> tuple[str, ...]:
        """Ids of the objects to which the plan does not keep the required gap, each once."""
        near = (r for r in self.rejects if r.code in (RejectCode.COLLISION, RejectCode.GAP))
        return tuple(dict.fromkeys(r.object_id for r in near if r.object_id is not None))

    def __str__(self) -> str:
        if self.accepted:
            return "accepted"
        return "; ".join(f"{r.code.value}: {r.detail}" for r in self.rejects)


def no_path(error: NoPathError) -> Verdict:
    """Return the verdict that refuses behaviors for which there is no path."""
    return Verdict(rejects=(RejectReason(code=RejectCode.NO_PATH, detail=str(error), failure=error.failure),))


OK = Verdict()
