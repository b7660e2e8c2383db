"""Detects a recovery: 15 m of new progress after an immobilization began."""

from __future__ import annotations

from dataclasses import dataclass, replace

from stucksolver.immobilization import Trigger
from stucksolver.scene import Status

RECOVERED_M = 15.0
"""New progress since the onset that counts as a recovery (m), as `HandBack.progress_m`."""


@dataclass(frozen=True)
class RecoveryWatch:
    """Watch over the current immobilization.

    `onset` is the time (s) and the progress on the route (m) at its beginning; None without an immobilization.
    """

    recovered_m: float = RECOVERED_M
    onset: tuple[float, float] | None = None

    @property
    def active(self) -> bool:
        """True during an immobilization without a recovery."""
        return self.onset is not None

    def advance(
        self, status: Status, slow_since_s: float | None, trigger: Trigger | None
    ) -> tuple[RecoveryWatch, float | None]:
        """Return the watch after one more tick, and at the tick of a recovery the time since the onset (s)."""
        if self.onset is None:
            if trigger is None:
                return self, None
            began_s = status.time_s if slow_since_s is None else slow_since_s
            return replace(self, onset=(began_s, status.progress_m)), None
        onset_s, onset_m = self.onset
        if status.progress_m - onset_m < self.recovered_m:
            return self, None
        return replace(self, onset=None), status.time_s - onset_s
