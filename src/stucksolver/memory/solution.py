"""A solution: what was done, without its figures. Another scene needs other figures for the same thing."""

from __future__ import annotations

from stucksolver.decision import RecoveryPlan
from stucksolver.decision.behaviors import (
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
from stucksolver.scene.model import Model

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
"""By what a plan is known, the most telling behaviour first: who backs up to swing out overtakes.

Pulling over, letting somebody out and calling for help are wishes or last resorts: they are not remembered."""


class Solution(Model):
    """What was done to get on; `side` only where a side was taken."""

    intent: GuidanceIntent
    side: Side | None = None

    @property
    def name(self) -> str:
        """For people and for the file: `overtake left`, `reroute`."""
        side = "" if self.side is None else f" {self.side.value}"
        return self.intent.value.replace("_", " ") + side


def solution_of(plan: RecoveryPlan) -> Solution | None:
    """What a plan does; None for one that only waits, stops or calls."""
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
