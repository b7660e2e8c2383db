"""What people may be asked to approve, and what they have approved."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.plan.behaviors import ApprovalLevel

RULES = ("solid_line", "emergency_scene", "school_bus", "level_crossing", "flagger", "red_light")
"""The rules that a person may be asked to waive, besides approving behaviors. Only an operator waives a red light."""
CLAIMS = ("soft_object", "long_stay")
"""What a person may confirm about an object: that it is as soft as it looks, and that it will stay."""
SCENES = ("emergency_scene", "school_bus", "level_crossing", "flagger")
RANKS = ("autonomous", "passenger", "operator", "forbid")
"""Ranks of approval, from the lowest to the highest."""


@dataclass(frozen=True)
class Approvals:
    """What people have approved for this plan: names of behaviors, of `RULES`, or of `CLAIMS`; and what is barred."""

    passenger: frozenset[str] = frozenset()
    operator: frozenset[str] = frozenset()
    barred: frozenset[str] = frozenset()
    """Behaviors that somebody's warning forbids, whoever approves them: `drive_over`."""

    def cover(self, what: str, needed: ApprovalLevel) -> bool:
        """True if the approvals cover `what` at the required rank. An operator may approve what a passenger may."""
        if needed is ApprovalLevel.AUTONOMOUS or what in self.operator:
            return True
        return needed is ApprovalLevel.PASSENGER and what in self.passenger


NOBODY = Approvals()
