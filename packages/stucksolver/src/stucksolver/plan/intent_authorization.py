"""Checks which plans a passenger's guidance authorizes: its interpreted intent must match the plan.

The reasoner that proposes a plan has no influence on this.
"""

from __future__ import annotations

from stucksolver.plan.decision import RecoveryPlan
from stucksolver.scene.interpretation import GuidanceIntent, Interpretation


def plan_matches_intent(reading: Interpretation | None, plan: RecoveryPlan) -> bool:
    """True if the plan does what the passenger requested.

    Only then may the plan begin while the ego is not immobilized.
    """
    if reading is None:
        return False
    if reading.intent is GuidanceIntent.OVERTAKE:
        return intent_authorizes(reading, plan)
    replans = plan.replan_route and reading.intent in (GuidanceIntent.REROUTE, GuidanceIntent.TURN_AROUND)
    does = any(reading.intent in behavior.intents for behavior in plan.behaviors)
    aside = reading.intent is GuidanceIntent.GO and any(behavior.shifts_laterally for behavior in plan.behaviors)
    return (does or replans) and not aside


def intent_authorizes(reading: Interpretation | None, plan: RecoveryPlan) -> bool:
    """True if the passenger requested to overtake, on the side of this plan.

    The guard then allows two more things: to pass a vehicle that is moving or has not been stationary for long, and to
    drive faster than in a recovery. Both apply to overtaking only.
    """
    if reading is None or reading.intent is not GuidanceIntent.OVERTAKE:
        return False
    sides = [behavior.passing_side for behavior in plan.behaviors if behavior.passing_side is not None]
    return bool(sides) and reading.side in (None, sides[0])
