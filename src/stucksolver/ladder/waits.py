"""How long each reason to wait is right, and how often it is looked at again."""

from __future__ import annotations

from pydantic import Field

from stucksolver.decision import WaitLimits, WaitReason
from stucksolver.scene.model import Model

SEEING = ("queue_moved_within_s", "unknown_vehicle_s", "hazard_or_parked_s")
NEVER_LONG = 1e9


class Patience(Model):
    """One reason to wait."""

    longest_s: float = Field(gt=0)
    """A wait that lasts longer has outlived its reason: the vehicle counts as immobilized."""
    check_every_s: float = Field(default=3.0, ge=0.5, le=60)


class Waits(Model):
    """The design's table of waits. What a reason needs to be *seen* as one is said by the first three values."""

    queue_moved_within_s: float = Field(default=60.0, ge=0)
    """A leader without hazard lights that moved so lately stands in a queue."""
    unknown_vehicle_s: float = Field(default=10.0, ge=0)
    """An unknown stopped vehicle is waited for so long before it counts as an obstacle,"""
    hazard_or_parked_s: float = Field(default=3.0, ge=0)
    """and so long with hazard lights or in a parked position."""
    reasons: dict[WaitReason, Patience]
    otherwise: Patience = Patience(longest_s=60.0, check_every_s=2.0)
    """For reasons that the table does not list."""

    def patience(self, reason: WaitReason) -> Patience:
        """How long, and how often to look. At the destination for ever; with no safe way not at all."""
        if reason is WaitReason.AT_DESTINATION:
            return Patience(longest_s=NEVER_LONG)
        return self.reasons.get(reason, self.otherwise)

    def is_wait(self, reason: WaitReason | None) -> bool:
        """Is that a reason to wait at all? `no_safe_way` only says that nothing was found."""
        return reason is not None and reason is not WaitReason.NO_SAFE_WAY

    def limits(self) -> WaitLimits:
        """The same for the rules and the guard."""
        return WaitLimits(
            light_s=self.patience(WaitReason.LIGHT).longest_s,
            yield_s=self.patience(WaitReason.YIELD).longest_s,
            **{name: getattr(self, name) for name in SEEING},
        )
