"""A solution: the kind of a plan, without its numbers, because another scene needs other numbers."""

from __future__ import annotations

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import (
    BackUp,
    BorrowOncomingLane,
    ChangeLane,
    Creep,
    DriveOver,
    KeepLane,
    Nudge,
    ReplanRoute,
)
from stucksolver.scene import GuidanceIntent, Side
from stucksolver.scene.base_model import FrozenModel

KINDS: tuple[tuple[type, GuidanceIntent], ...] = (
    (ReplanRoute, GuidanceIntent.REROUTE),
    (DriveOver, GuidanceIntent.DRIVE_OVER),
    (BorrowOncomingLane, GuidanceIntent.OVERTAKE),
    (ChangeLane, GuidanceIntent.OVERTAKE),
    (Nudge, GuidanceIntent.OVERTAKE),
    (BackUp, GuidanceIntent.BACK_UP),
    (KeepLane, GuidanceIntent.GO),
    (Creep, GuidanceIntent.GO),
)
"""Kinds of plans, the most significant behavior first: a vehicle that backs up in order to pass overtakes.

Pulling over, stopping for an exit and requesting assistance are requests or last resorts and are not stored.
"""


class Solution(FrozenModel):
    """Kind of a plan that moves the vehicle on. `side` is set only if the plan used a side."""

    intent: GuidanceIntent
    side: Side | None = None

    @property
    def name(self) -> str:
        """Name for people and for the file: `overtake left`, `reroute`."""
        side = "" if self.side is None else f" {self.side.value}"
        return self.intent.value.replace("_", " ") + side


def solution_of(plan: RecoveryPlan) -> Solution | None:
    """Return the solution of a plan; None for a plan that only waits, stops or calls."""
    if plan.replan_route and not any(isinstance(b, ChangeLane | Nudge) for b in plan.behaviors):
        return Solution(intent=GuidanceIntent.REROUTE)
    for kind, intent in KINDS:
        behavior = next((b for b in plan.behaviors if isinstance(b, kind)), None)
        if behavior is not None:
            return Solution(intent=intent, side=_side(behavior))
    return None


def _side(behavior: object) -> Side | None:
    if isinstance(behavior, BorrowOncomingLane):
        return Side.LEFT
    return Side(behavior.side) if isinstance(behavior, ChangeLane | Nudge) else None
