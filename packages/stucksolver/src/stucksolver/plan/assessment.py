"""Assessment of a whole plan by the guard, for a reasoner that compares plans before it answers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from stucksolver.plan.decision import RecoveryPlan
from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.failed_attempts import PlanFailure, RejectCode

MOST_FREE_M = 200.0
"""Largest free distance that is reported (m)."""


class Shortfall(FrozenModel):
    """A requirement of the guard that a plan does not meet.

    Attributes:
        code: Code of the reject reason.
        detail: The reject reason for people.
        object_id: Object that it concerns, if any.
        failure: Reason for which there is no path, for `RejectCode.NO_PATH`.
        missing: How much is missing (in `unit`, positive); None if the requirement has no amount.
        unit: Unit of `missing`.
        passing: True if it ends when traffic has moved on.
        approval: True if a person's approval can remove it.
    """

    code: RejectCode
    detail: str
    object_id: str | None = None
    failure: PlanFailure | None = None
    missing: float | None = None
    unit: Literal["m", "s", "m/s"] | None = None
    passing: bool = False
    approval: bool = False


class PlanAssessment(FrozenModel):
    """Assessment of a whole plan, step by step.

    The first step is checked in the present surroundings. Later steps are checked where the steps before them end:
    stationary objects stay, traffic is left out, and sight distances are estimated from there.

    Attributes:
        step: Index of the first behavior of the refused step; None if no step is refused.
        shortfalls: Requirements that the refused step does not meet.
        duration_s: Expected duration of the accepted steps (s).
        way_m: Length of their paths (m).
        back_m: Part of `way_m` in reverse (m).
        progress_m: Distance along the route from the present position to the end of the last accepted step (m).
        offset_m: Lateral offset from the route's lane there (m, left positive).
        free_m: Free distance ahead there, at that offset (m), at most `MOST_FREE_M`.
        oncoming_m: Length of the paths in oncoming lanes (m).
        leaves_zone: True if the ego's body touches a zone now and none at the end.
        gap_m: Smallest gap to a stationary object on these paths (m); None without one, and before a path is proven.
        gap_margin_m: Smallest excess of such a gap over the required one, where the ego comes nearer than now (m).
        sight_margin_m: Smallest excess of the sight distance of a pass through an oncoming lane (m); None without one.
        passed: Ids of the objects ahead that are behind the ego at the end, if moving ones keep their speed.
    """

    step: int | None = None
    shortfalls: tuple[Shortfall, ...] = ()
    duration_s: float = 0.0
    way_m: float = 0.0
    back_m: float = 0.0
    progress_m: float = 0.0
    offset_m: float = 0.0
    free_m: float = 0.0
    oncoming_m: float = 0.0
    leaves_zone: bool = False
    gap_m: float | None = None
    gap_margin_m: float | None = None
    sight_margin_m: float | None = None
    passed: tuple[str, ...] = ()

    @property
    def accepted(self) -> bool:
        """True if no step is refused."""
        return self.step is None

    @property
    def waits_for_traffic(self) -> bool:
        """True if the plan is refused only for traffic that will move on."""
        return bool(self.shortfalls) and all(item.passing for item in self.shortfalls)

    @property
    def needs_approval(self) -> bool:
        """True if a person's approval is all that is missing, apart from traffic that will move on."""
        return any(item.approval for item in self.shortfalls) and all(
            item.approval or item.passing for item in self.shortfalls
        )


PlanAssessor = Callable[[RecoveryPlan], PlanAssessment]
"""Returns the guard's assessment of a whole plan in a query's surroundings. The reasoner's thread may call it."""
