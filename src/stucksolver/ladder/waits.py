"""How long each reason to wait is right, and how often it is checked again."""

from __future__ import annotations

from pydantic import Field

from stucksolver.decision import WaitLimits, WaitReason
from stucksolver.scene.model import Model

SEEING = ("queue_moved_within_s", "unknown_vehicle_s", "hazard_or_parked_s")
NEVER_LONG = 1e9


class Patience(Model):
    """One reason to wait."""

    longest_s: float = Field(gt=0)
    """A longer wait has outlived its reason: the vehicle counts as immobilized."""
    check_every_s: float = Field(default=3.0, ge=0.5, le=60)


class Waits(Model):
    """The design's table of waits. The first three values say what must be *seen* for a reason to hold."""

    queue_moved_within_s: float = Field(default=60.0, ge=0)
    """A leader without hazard lights that moved within this time stands in a queue."""
    unknown_vehicle_s: float = Field(default=10.0, ge=0)
    """An unknown stopped vehicle counts as an obstacle after this time,"""
    hazard_or_parked_s: float = Field(default=3.0, ge=0)
    """and after this time with hazard lights or in a parked position."""
    reasons: dict[WaitReason, Patience]
    otherwise: Patience = Patience(longest_s=60.0, check_every_s=2.0)
    """For reasons that are not in the table."""

    def patience(self, reason: WaitReason) -> Patience:
        """Return how long to wait and how often to look. Unlimited at the destination; zero without a safe way."""
        if reason is WaitReason.AT_DESTINATION:
            return Patience(longest_s=NEVER_LONG)
        return self.reasons.get(reason, self.otherwise)

    def is_wait(self, reason: WaitReason | None) -> bool:
        """True if this is a reason to wait. `no_safe_way` only says that nothing was found."""
        return reason is not None and reason is not WaitReason.NO_SAFE_WAY

    def limits(self) -> WaitLimits:
        """The same numbers for the rules and the guard."""
        return WaitLimits(
            light_s=self.patience(WaitReason.LIGHT).longest_s,
            yield_s=self.patience(WaitReason.YIELD).longest_s,
            **{name: getattr(self, name) for name in SEEING},
        )
