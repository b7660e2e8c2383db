"""What people may be asked to release, and what they have released."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.decision.behaviors import Release

RULES = ("solid_line", "emergency_scene", "school_bus", "level_crossing", "flagger", "red_light")
"""Besides the names of behaviours, what a person may be asked to release. A red light: an operator only."""
CLAIMS = ("soft_object", "long_stay")
"""What a person may confirm of what is seen: that it is the soft thing it is taken for, that it will stay."""
SCENES = ("emergency_scene", "school_bus", "level_crossing", "flagger")
RANKS = ("autonomous", "passenger", "operator", "forbid")
"""From the least to the most that may be asked for."""


@dataclass(frozen=True)
class Approvals:
    """What people have said yes to for the plan at hand: names of behaviours, of `RULES`, or of `CLAIMS`."""

    passenger: frozenset[str] = frozenset()
    operator: frozenset[str] = frozenset()

    def cover(self, what: str, needed: Release) -> bool:
        """Is that enough for something that needs a yes of this rank? An operator's yes is also a passenger's."""
        if needed is Release.AUTONOMOUS or what in self.operator:
            return True
        return needed is Release.PASSENGER and what in self.passenger


NOBODY = Approvals()
