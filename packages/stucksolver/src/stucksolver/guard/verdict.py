"""Verdict of the guard on a plan."""

from __future__ import annotations

from typing import Literal

from stucksolver.plan.behaviors import AbortAction, NoPathError
from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.failed_attempts import PlanFailure, RejectCode


class RejectReason(FrozenModel):
    """Reject reason, with the object, the time (s from now) and the gap (m) if they apply."""

    code: RejectCode
    detail: str
    object_id: str | None = None
    time_s: float | None = None
    gap_m: float | None = None
    failure: PlanFailure | None = None
    """Reason for which there is no path, for `RejectCode.NO_PATH`."""
    needed_m: float | None = None
    """Required sight distance (m), for `RejectCode.ONCOMING_SIGHT`. `time_s` is the time for traffic to arrive."""
    seen_m: float | None = None
    """Available sight distance (m), for the same code."""
    margin: float | None = None
    """Margin of the requirement, in `unit`: negative, because it is not met. None if it has no amount."""
    unit: Literal["m", "s", "m/s"] | None = None
    """Unit of `margin`."""

    @property
    def missing(self) -> float | None:
        """Amount by which the requirement is missed, in `unit`, at least 0; None if it has no amount."""
        return None if self.margin is None else max(-self.margin, 0.0)


class SightDistanceProof(FrozenModel):
    """Proof of a pass: required and available sight distance in the oncoming lane (m), and the unchecked time (s)."""

    needed_m: float
    seen_m: float
    unseen_s: float


class Verdict(FrozenModel):
    """Verdict of the guard. A plan is accepted if it has no reject reasons.

    Attributes:
        rejects: Reject reasons.
        abort: Abort action; set only while a plan runs.
        brake_mps2: Deceleration (m/s²), if the abort is to brake.
        sight: Proof of an accepted pass through the oncoming lane.
    """

    rejects: tuple[RejectReason, ...] = ()
    abort: AbortAction | None = None
    brake_mps2: float | None = None
    sight: SightDistanceProof | None = None

    @property
    def accepted(self) -> bool:
        """True if no check rejects the plan."""
        return not self.rejects

    @property
    def codes(self) -> tuple[RejectCode, ...]:
        """Codes of the reject reasons, each once."""
        return tuple(dict.fromkeys(r.code for r in self.rejects))

    @property
    def failures(self) -> tuple[PlanFailure, ...]:
        """Reasons for which there is no path, each once."""
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
    """Return the verdict that rejects behaviors without a path."""
    short_m = error.short_m
    return Verdict(
        rejects=(
            RejectReason(
                code=RejectCode.NO_PATH,
                detail=str(error),
                failure=error.failure,
                object_id=error.object_id,
                margin=None if short_m is None else -short_m,
                unit=None if short_m is None else "m",
            ),
        )
    )


OK = Verdict()
