"""Which approvals of a person can remove a reason for refusal, and which approvals a plan lacks."""

from __future__ import annotations

from stucksolver.guard import RULES, Approvals, Guard, RejectCode, RejectReason, Verdict
from stucksolver.plan import RecoveryPlan

RELEASABLE = frozenset(name for name in RULES if name != "red_light")
"""Rules for which a person may be asked, for any plan. A red light is asked about only if the plan does nothing
else.
"""

RED_LIGHT = ("red_light",)
ASKABLE = frozenset({RejectCode.APPROVAL, RejectCode.AUTHORITY, RejectCode.SOLID_LINE, RejectCode.RED_LIGHT})
"""Reasons for refusal that a person's approval can remove."""


def check_authorized(plan: RecoveryPlan, guard: Guard, has: Approvals) -> Verdict | None:
    """Refuse a plan if any of its behaviors lacks an approval, even a late one: the plan would end half-way."""
    lacking = [
        RejectReason(code=RejectCode.APPROVAL, detail=f"{name} needs a yes from the {needed.value}")
        for name in dict.fromkeys(b.name for b in plan.behaviors)
        if not has.cover(name, needed := guard.policy.release(name))
    ]
    return Verdict(rejects=tuple(lacking)) if lacking else None


def approvable_rules(plan: RecoveryPlan) -> frozenset[str]:
    """The rules for which a person may be asked. A red light only if the plan creeps across it and does nothing
    else.
    """
    creeps = len(plan.behaviors) == 1 and plan.behaviors[0].may_cross_red_light
    return RELEASABLE | set(RED_LIGHT) if creeps else RELEASABLE
