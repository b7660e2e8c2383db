"""What people may be asked to release, and what they have released."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.decision.behaviors import Release

RULES = ("solid_line", "emergency_scene", "school_bus", "level_crossing", "flagger", "red_light")
"""Besides the names of behaviours, the rules that a person may be asked to release. A red light: an operator only."""
CLAIMS = ("soft_object", "long_stay")
"""What a person may confirm about an object: that it is the soft thing it looks like, and that it will stay."""
SCENES = ("emergency_scene", "school_bus", "level_crossing", "flagger")
RANKS = ("autonomous", "passenger", "operator", "forbid")
"""Ranks of approval, from the lowest to the highest."""


@dataclass(frozen=True)
class Approvals:
    """What people have approved for this plan: names of behaviours, of `RULES`, or of `CLAIMS`."""

    passenger: frozenset[str] = frozenset()
    operator: frozenset[str] = frozenset()

    def cover(self, what: str, needed: Release) -> bool:
        """True if the approvals suffice for something of this rank. An operator's approval also counts as a
        passenger's.
        """
        if needed is Release.AUTONOMOUS or what in self.operator:
            return True
        return needed is Release.PASSENGER and what in self.passenger


NOBODY = Approvals()
