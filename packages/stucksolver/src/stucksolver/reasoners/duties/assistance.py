"""Calls for help: when a person should be asked, because nothing legal and safe is left."""

from __future__ import annotations

from stucksolver.plan import RecoveryPlan, WaitLimits, WaitReason
from stucksolver.plan.behaviors import RequestAssistance
from stucksolver.scene import Scene

NO_WAY_S = 120.0
"""After this long without a safe plan, a person is asked for help (s)."""


def call_for_help(scene: Scene, wait: WaitReason | None, why: str, limits: WaitLimits) -> RecoveryPlan | None:
    """Return a call for help if nothing legal is left: a light stays red, or there has been no safe plan for long."""
    if not scene.offers("request_assistance"):
        return None
    after = {WaitReason.LIGHT: limits.light_s, WaitReason.NO_SAFE_WAY: NO_WAY_S}
    if wait is None or scene.ego.stopped_for_s <= after.get(wait, float("inf")):
        return None
    reason = f"stopped for {scene.ego.stopped_for_s:.0f} s: {why}"[:200]
    return RecoveryPlan(behaviors=(RequestAssistance(reason=reason),))
