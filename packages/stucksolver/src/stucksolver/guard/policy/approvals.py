"""Rules and claims that people may be asked to approve, and their approvals."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.plan.behaviors import ApprovalLevel

RULES = ("solid_line", "emergency_scene", "school_bus", "level_crossing", "flagger", "red_light")
"""Rules that a person may be asked to waive, besides approving behaviors. Only an operator waives a red light."""
CLAIMS = ("soft_object", "long_stay")
"""Claims about an object that a person may confirm: that it is soft, and that it will stay."""
SCENES = ("emergency_scene", "school_bus", "level_crossing", "flagger")
"""Rules for scenes with their own level of approval; see `GuardPolicy.scene_release`."""
RANKS = ("autonomous", "passenger", "operator", "forbid")
"""Levels of approval, from the lowest to the highest."""


@dataclass(frozen=True)
class Approvals:
    """Approvals for one plan: names of behaviors, of `RULES` or of `CLAIMS`, and barred behaviors."""

    passenger: frozenset[str] = frozenset()
    operator: frozenset[str] = frozenset()
    barred: frozenset[str] = frozenset()
    """Behaviors that a person's warning forbids, regardless of approvals: `drive_over`."""

    def cover(self, what: str, needed: ApprovalLevel) -> bool:
        """True if the approvals cover `what` at the required level. An operator may approve what a passenger may."""
        if needed is ApprovalLevel.AUTONOMOUS or what in self.operator:
            return True
        return needed is ApprovalLevel.PASSENGER and what in self.passenger


NOBODY = Approvals()
