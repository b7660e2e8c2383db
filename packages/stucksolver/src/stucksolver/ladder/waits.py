"""Limits of each reason to wait, and intervals between its checks."""

from __future__ import annotations

from pydantic import Field

from stucksolver.plan import WaitLimits, WaitReason
from stucksolver.scene.base_model import FrozenModel

SEEING = ("queue_moved_within_s", "unknown_vehicle_s", "hazard_or_parked_s")
"""Names of the limits on observed times, which `WaitLimits` shares."""
NEVER_LONG = 1e9
"""Limit of a wait that has none (s): 30 years."""


class WaitLimit(FrozenModel):
    """Limits of one reason to wait."""

    longest_s: float = Field(gt=0)
    """Time after which the reason no longer holds and the vehicle counts as immobilized (s)."""
    check_every_s: float = Field(default=3.0, ge=0.5, le=60)


class WaitPolicy(FrozenModel):
    """The design's table of waits. The first three values are conditions on observations for a reason to hold."""

    queue_moved_within_s: float = Field(default=60.0, ge=0)
    """Time since its last motion within which a lead without hazard lights is in a queue (s)."""
    unknown_vehicle_s: float = Field(default=10.0, ge=0)
    """Time after which a stopped vehicle of unknown intent counts as an obstacle (s)."""
    hazard_or_parked_s: float = Field(default=3.0, ge=0)
    """The same with hazard lights or in a parked position (s)."""
    reasons: dict[WaitReason, WaitLimit]
    otherwise: WaitLimit = WaitLimit(longest_s=60.0, check_every_s=2.0)
    """Limits of reasons that are not in the table."""

    def patience(self, reason: WaitReason) -> WaitLimit:
        """Return limit and check interval of a reason; unlimited at the destination."""
        if reason is WaitReason.AT_DESTINATION:
            return WaitLimit(longest_s=NEVER_LONG)
        return self.reasons.get(reason, self.otherwise)

    def is_wait(self, reason: WaitReason | None) -> bool:
        """True if this is a legitimate reason to wait. `no_safe_way` only means that no safe plan was found."""
        return reason is not None and reason is not WaitReason.NO_SAFE_WAY

    def limits(self) -> WaitLimits:
        """Return the same numbers in the form that the duties and the guard use."""
        return WaitLimits(
            light_s=self.patience(WaitReason.LIGHT).longest_s,
            yield_s=self.patience(WaitReason.YIELD).longest_s,
            **{name: getattr(self, name) for name in SEEING},
        )
