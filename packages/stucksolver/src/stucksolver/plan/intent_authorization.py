"""Checks which plans a passenger's guidance authorizes: its interpreted intent must match the plan.

The reasoner that proposes a plan has no influence on this.
"""

from __future__ import annotations

from stucksolver.plan.behaviors import (
    BackUp,
    BorrowOncomingLane,
    ChangeLane,
    Creep,
    DriveOver,
    KeepLane,
    NoseOut,
    Nudge,
    PullOver,
    ReplanRoute,
    TurnAround,
)
from stucksolver.plan.decision import RecoveryPlan
from stucksolver.scene.interpretation import GuidanceIntent, Interpretation, Side

DOES: dict[GuidanceIntent, tuple[type, ...]] = {
    GuidanceIntent.OVERTAKE: (BorrowOncomingLane, ChangeLane, Nudge),
    GuidanceIntent.GO: (KeepLane, Creep),
    GuidanceIntent.BACK_UP: (BackUp,),
    GuidanceIntent.REROUTE: (ReplanRoute,),
    GuidanceIntent.TURN_AROUND: (TurnAround, ReplanRoute),
    GuidanceIntent.DRIVE_OVER: (DriveOver,),
    GuidanceIntent.PULL_OVER: (PullOver,),
    GuidanceIntent.LET_ME_OUT: (PullOver,),
}
"""Behaviors that do what an intent requests."""
LATERAL = (BorrowOncomingLane, ChangeLane, NoseOut, Nudge)


def plan_matches_intent(reading: Interpretation | None, plan: RecoveryPlan) -> bool:
    """True if the plan does what the passenger requested.

    Only then may the plan begin while the ego is not immobilized.
    """
    if reading is None or reading.intent not in DOES:
        return False
    if reading.intent is GuidanceIntent.OVERTAKE:
        return intent_authorizes(reading, plan)
    replans = plan.replan_route and reading.intent in (GuidanceIntent.REROUTE, GuidanceIntent.TURN_AROUND)
    does = any(isinstance(behavior, DOES[reading.intent]) for behavior in plan.behaviors)
    aside = reading.intent is GuidanceIntent.GO and any(isinstance(behavior, LATERAL) for behavior in plan.behaviors)
    return (does or replans) and not aside


def intent_authorizes(reading: Interpretation | None, plan: RecoveryPlan) -> bool:
    """True if the passenger requested to overtake, on the side of this plan.

    The guard then allows two more things: to pass a vehicle that is moving or has not been stationary for long, and to
    drive faster than in a recovery. Both apply to overtaking only.
    """
    if reading is None or reading.intent is not GuidanceIntent.OVERTAKE:
        return False
    sides = [side for side in map(_side, plan.behaviors) if side is not None]
    return bool(sides) and reading.side in (None, sides[0])


def _side(behavior: object) -> Side | None:
    """Return the side on which a behavior leaves the lane; None if the behavior stays in the lane."""
    if isinstance(behavior, BorrowOncomingLane):
        return Side.LEFT
    return Side(behavior.side) if isinstance(behavior, ChangeLane | Nudge) else None
